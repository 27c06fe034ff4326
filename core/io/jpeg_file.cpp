#include "core/io/jpeg_file.h"

#include <csetjmp>
#include <cstddef>
#include <cstdio>
#include <cstdlib>
// After what it takes for granted: it does not include <cstdio> itself.
#include <jpeglib.h>

namespace rigcal {
namespace {

// A progressive image may be cut into scans without end, each over all pixels.
constexpr int most_scans = 100;

// What libjpeg calls instead of ending the program.
struct Trouble {
  jpeg_error_mgr calls{};
  jpeg_progress_mgr progress{};
  std::jmp_buf back{};
};

template <typename Codec>
void attach(Codec& codec, Trouble& trouble) {
  codec.err = jpeg_std_error(&trouble.calls);
  codec.client_data = &trouble;
  trouble.calls.error_exit = [](j_common_ptr common) {
    std::longjmp(static_cast<Trouble*>(common->client_data)->back, 1);
  };
  trouble.calls.output_message = [](j_common_ptr) {};
}

struct Decoder {
  Decoder() {
    attach(codec, trouble);
    trouble.progress.progress_monitor = [](j_common_ptr common) {
      if (reinterpret_cast<j_decompress_ptr>(common)->input_scan_number > most_scans) common->err->error_exit(common);
    };
  }
  Decoder(const Decoder&) = delete;
  Decoder& operator=(const Decoder&) = delete;
  ~Decoder() { jpeg_destroy_decompress(&codec); }

  // From setjmp on nothing may be made here that has a destructor: an error jumps over it.
  bool run(ByteView file, Image& image) {
    if (setjmp(trouble.back) != 0) return false;
    jpeg_create_decompress(&codec);
    codec.progress = &trouble.progress;
    jpeg_mem_src(&codec, file.data(), file.size());
    jpeg_read_header(&codec, TRUE);
    const bool grey = codec.jpeg_color_space == JCS_GRAYSCALE;
    if (codec.num_components != 1 && codec.num_components != 3) return false;
    codec.out_color_space = grey ? JCS_GRAYSCALE : JCS_RGB;
    jpeg_start_decompress(&codec);
    image.width = static_cast<int>(codec.output_width);
    image.height = static_cast<int>(codec.output_height);
    image.channels = grey ? 1 : 3;
    image.bytes.resize(image.row_bytes() * codec.output_height);
    while (codec.output_scanline < codec.output_height) {
      JSAMPROW row = image.bytes.data() + codec.output_scanline * image.row_bytes();
      jpeg_read_scanlines(&codec, &row, 1);
    }
    jpeg_finish_decompress(&codec);
    return true;
  }

  jpeg_decompress_struct codec{};
  Trouble trouble;
};

struct Encoder {
  Encoder() { attach(codec, trouble); }
  Encoder(const Encoder&) = delete;
  Encoder& operator=(const Encoder&) = delete;
  ~Encoder() {
    jpeg_destroy_compress(&codec);
    std::free(bytes);  // NOLINT(cppcoreguidelines-no-malloc): libjpeg's
  }

  // As for Decoder::run.
  bool run(const Image& image, int quality) {
    if (setjmp(trouble.back) != 0) {
      // Only by this does libjpeg tell where its buffer is once that has grown.
      if (codec.dest != nullptr) codec.dest->term_destination(&codec);
      return false;
    }
    jpeg_create_compress(&codec);
    jpeg_mem_dest(&codec, &bytes, &size);
    codec.image_width = static_cast<JDIMENSION>(image.width);
    codec.image_height = static_cast<JDIMENSION>(image.height);
    codec.input_components = image.channels;
    codec.in_color_space = image.channels == 1 ? JCS_GRAYSCALE : JCS_RGB;
    jpeg_set_defaults(&codec);
    jpeg_set_quality(&codec, quality, TRUE);
    jpeg_start_compress(&codec, TRUE);
    while (codec.next_scanline < codec.image_height) {
      // libjpeg only reads, but does not say so.
      JSAMPROW row = const_cast<JSAMPROW>(image.bytes.data() + codec.next_scanline * image.row_bytes());
      jpeg_write_scanlines(&codec, &row, 1);
    }
    jpeg_finish_compress(&codec);
    return true;
  }

  jpeg_compress_struct codec{};
  Trouble trouble;
  unsigned char* bytes = nullptr;
  unsigned long size = 0;
};

}  // namespace

std::optional<JpegSegment> JpegSegments::next() {
  constexpr unsigned fill = 0xFF;
  constexpr unsigned start_of_scan = 0xDA;
  while (at_ + 1 < file_.size() && file_[at_] == 0xFF && file_[at_ + 1] == fill) ++at_;
  if (at_ + 4 > file_.size() || file_[at_] != 0xFF || file_[at_ + 1] == start_of_scan) return std::nullopt;
  const std::size_t length = static_cast<std::size_t>(file_[at_ + 2]) << 8U | file_[at_ + 3];
  if (length < 2 || length > file_.size() - at_ - 2) return std::nullopt;
  const JpegSegment segment{file_[at_ + 1], file_.subspan(at_ + 4, length - 2)};
  at_ += 2 + length;
  return segment;
}

std::optional<Image> decode_jpeg(ByteView file) {
  Decoder decoder;
  Image image;
  if (!decoder.run(file, image)) return std::nullopt;
  return image;
}

Expected<std::vector<std::uint8_t>> encode_jpeg(const Image& image, int quality) {
  if (!image.is_consistent() || image.bits != 8)
    return input_error("an image's size, channels and bytes contradict each other, or it has 16 bits");
  Encoder encoder;
  if (!encoder.run(image, quality)) return input_error("the image cannot be written as JPEG");
  return std::vector<std::uint8_t>(encoder.bytes, encoder.bytes + encoder.size);
}

}  // namespace rigcal
