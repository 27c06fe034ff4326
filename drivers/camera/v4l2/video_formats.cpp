#include "drivers/camera/v4l2/video_formats.h"

#include <linux/videodev2.h>

#include <array>

namespace rigcal::camera {
namespace {

struct Row {
  std::uint32_t fourcc;
  std::string_view name;
};
constexpr std::array<Row, 27> table{{
    {V4L2_PIX_FMT_GREY, "Mono8"},        {V4L2_PIX_FMT_Y10, "Mono10"},        {V4L2_PIX_FMT_Y12, "Mono12"},
    {V4L2_PIX_FMT_Y14, "Mono14"},        {V4L2_PIX_FMT_Y16, "Mono16"},        {V4L2_PIX_FMT_SRGGB8, "BayerRG8"},
    {V4L2_PIX_FMT_SGRBG8, "BayerGR8"},   {V4L2_PIX_FMT_SGBRG8, "BayerGB8"},   {V4L2_PIX_FMT_SBGGR8, "BayerBG8"},
    {V4L2_PIX_FMT_SRGGB10, "BayerRG10"}, {V4L2_PIX_FMT_SGRBG10, "BayerGR10"}, {V4L2_PIX_FMT_SGBRG10, "BayerGB10"},
    {V4L2_PIX_FMT_SBGGR10, "BayerBG10"}, {V4L2_PIX_FMT_SRGGB12, "BayerRG12"}, {V4L2_PIX_FMT_SGRBG12, "BayerGR12"},
    {V4L2_PIX_FMT_SGBRG12, "BayerGB12"}, {V4L2_PIX_FMT_SBGGR12, "BayerBG12"}, {V4L2_PIX_FMT_SRGGB14, "BayerRG14"},
    {V4L2_PIX_FMT_SGRBG14, "BayerGR14"}, {V4L2_PIX_FMT_SGBRG14, "BayerGB14"}, {V4L2_PIX_FMT_SBGGR14, "BayerBG14"},
    {V4L2_PIX_FMT_SRGGB16, "BayerRG16"}, {V4L2_PIX_FMT_SGRBG16, "BayerGR16"}, {V4L2_PIX_FMT_SGBRG16, "BayerGB16"},
    {V4L2_PIX_FMT_SBGGR16, "BayerBG16"}, {V4L2_PIX_FMT_RGB24, "RGB8"},        {V4L2_PIX_FMT_BGR24, "BGR8"},
}};

}  // namespace

std::string_view name_of_fourcc(std::uint32_t fourcc) {
  for (const Row& row : table) {
    if (row.fourcc == fourcc) return row.name;
  }
  return {};
}

std::uint32_t fourcc_of(std::string_view name) {
  for (const Row& row : table) {
    if (row.name == name) return row.fourcc;
  }
  return 0;
}

}  // namespace rigcal::camera
