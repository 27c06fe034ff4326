#include "core/pipeline/late_images.h"

namespace rigcal {

std::vector<CameraView> views_moved(std::span<const CameraView> views, int by, const std::vector<char>& stop_known) {
  std::vector<CameraView> moved;
  for (const CameraView& view : views) {
    const int stop = view.stop + by;
    if (stop < 0 || stop >= static_cast<int>(stop_known.size()) || stop_known[static_cast<std::size_t>(stop)] == 0)
      continue;
    moved.push_back(view);
    moved.back().stop = stop;
  }
  return moved;
}

std::string wrong_stops_words(int by) {
  return std::string("its images do not fit their stops, but fit well where each is taken as of the stop ") +
         (by < 0 ? "before its own: they came a stop late, or are counted so"
                 : "after its own: they came a stop early, or are counted so") +
         "; mend the numbers in their names, or stamps and stops in frames.csv, and calibrate again";
}

}  // namespace rigcal
