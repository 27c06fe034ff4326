#include <png.h>

#include <csetjmp>
#include <cstring>

#include "core/io/png_file.h"

namespace rigcal {
namespace {

// What an additional chunk (a colour profile, a text) may become when it is unpacked.
constexpr png_alloc_size_t most_chunk_bytes = png_alloc_size_t{1} << 20U;

void take(png_structp png, png_bytep to, std::size_t bytes) {
  auto* rest = static_cast<ByteView*>(png_get_io_ptr(png));
  if (bytes > rest->size()) png_error(png, "the file ends here");
  std::memcpy(to, rest->data(), bytes);
  *rest = rest->subspan(bytes);
}

struct Reader {
  explicit Reader(ByteView file) : rest(file) {
    const auto jump = [](png_structp broken, png_const_charp) { png_longjmp(broken, 1); };
    const auto say_nothing = [](png_structp, png_const_charp) {};
    png = png_create_read_struct(PNG_LIBPNG_VER_STRING, nullptr, jump, say_nothing);
    if (png != nullptr) info = png_create_info_struct(png);
  }
  Reader(const Reader&) = delete;
  Reader& operator=(const Reader&) = delete;
  ~Reader() { png_destroy_read_struct(&png, &info, nullptr); }

  // From setjmp on nothing may be made here that has a destructor: an error jumps over it.
  bool run(Image& image) {
    if (png == nullptr || info == nullptr) return false;
    if (setjmp(png_jmpbuf(png)) != 0) return false;
    png_set_chunk_malloc_max(png, most_chunk_bytes);
    png_set_read_fn(png, &rest, take);
    png_read_info(png, info);
    const png_byte kind = png_get_color_type(png, info);
    png_set_palette_to_rgb(png);
    png_set_expand_gray_1_2_4_to_8(png);
    png_set_strip_alpha(png);
    png_set_swap(png);  // low byte first
    png_set_interlace_handling(png);
    png_read_update_info(png, info);
    image.width = static_cast<int>(png_get_image_width(png, info));
    image.height = static_cast<int>(png_get_image_height(png, info));
    image.channels = (kind & PNG_COLOR_MASK_COLOR) == 0 ? 1 : 3;
    image.bits = png_get_bit_depth(png, info);
    if (png_get_rowbytes(png, info) != image.row_bytes()) return false;
    image.bytes.resize(image.row_bytes() * static_cast<std::size_t>(image.height));
    rows.resize(static_cast<std::size_t>(image.height));
    for (std::size_t y = 0; y < rows.size(); ++y) rows[y] = image.bytes.data() + y * image.row_bytes();
    png_read_image(png, rows.data());
    png_read_end(png, nullptr);
    return true;
  }

  ByteView rest;
  png_structp png = nullptr;
  png_infop info = nullptr;
  std::vector<png_bytep> rows;
};

}  // namespace

std::optional<Image> decode_png(ByteView file) {
  Reader reader(file);
  Image image;
  if (!reader.run(image)) return std::nullopt;
  return image;
}

}  // namespace rigcal
