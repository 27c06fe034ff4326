#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "apps/recording/batch_source.h"
#include "core/records/image.h"
#include "core/records/records.h"
#include "core/rig/rig.h"

namespace rigcal {

/// Writes the images of a recording as a session holds them: images/<camera>/000000.png and frames.csv. Pixels are
/// written as they came: a compressed image's file byte for byte, raw ones as PNG without loss, Bayer as grey.
class ImageFiles {
 public:
  /// `folder` is the session's images; it is made with the first image.
  ImageFiles(std::string folder, const Rig& rig) : folder_(std::move(folder)), rig_(rig) {}

  /// From now on takes none: others than the recording's own are given.
  void take_none() { takes_ = false; }
  /// Takes all that was written away again.
  Expected<void> restart();
  void write(const RecordedImage& image);
  /// The first error of any write; it ends the writing.
  [[nodiscard]] Expected<void> status() const { return status_; }
  /// Writes frames.csv of every camera, with the stop that contains each image's exposure.
  Expected<void> finish(const std::vector<Stop>& stops);

  [[nodiscard]] std::uint64_t images() const;
  /// Where pixels that became grey are of a Bayer mosaic and the rig file does not say so, or names another layout: the
  /// pixel_format that they want, by sensor.
  [[nodiscard]] std::map<int, std::string> missing_formats() const;
  /// Of the images that could not be written, because their encoding is not known: one sentence a camera.
  [[nodiscard]] std::vector<std::string> warnings() const;

 private:
  struct Camera {
    std::vector<FrameRecord> frames;
    std::uint64_t unknown = 0;
    std::string first_unknown;
    std::string bayer;  ///< The pixel_format of the first image that is a mosaic.
  };
  [[nodiscard]] std::string camera_folder(int sensor) const;
  Expected<void> write_frame(const RecordedImage& image, Camera& camera) const;

  std::string folder_;
  const Rig& rig_;
  std::map<int, Camera> cameras_;
  bool takes_ = true;
  Expected<void> status_;
};

}  // namespace rigcal
