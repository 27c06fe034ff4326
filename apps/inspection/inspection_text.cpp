#include <cstdarg>
#include <cstdio>

#include "apps/inspection/inspection.h"
#include "core/base/seconds.h"

namespace rigcal {
namespace {

[[gnu::format(printf, 2, 3)]] void append(std::string& text, const char* format, ...) {
  char line[400];
  va_list arguments;
  va_start(arguments, format);
  std::vsnprintf(line, sizeof line, format, arguments);
  va_end(arguments);
  text += line;
}

double number(const Inspection& json, const char* key) { return json.at(key).get<double>(); }

void append_counts(std::string& text, const Inspection& counts) {
  for (const auto& [name, count] : counts.items()) append(text, "  %s %.0f", name.c_str(), count.get<double>());
  text += "\n";
}

std::string device_name(const Inspection& device) {
  return device.value("sensor", device.value("broadcast_code", "-"));
}

void append_devices(std::string& text, const Inspection& devices) {
  append(text, "%-16s %-15s %9s %10s %9s %8s %7s %9s %9s\n", "device", "address", "seconds", "packets/s", "points",
         "lost", "gaps", "drift ppm", "jitter us");
  for (const Inspection& device : devices) {
    const Inspection& packets = device["point_packets"];
    append(text, "%-16s %-15s %9.1f %10.1f %8.2fM %7.3f%% %7.0f %9.1f %9.1f\n", device_name(device).c_str(),
           device["ip"].get<std::string>().c_str(), number(device, "seconds"), number(packets, "packets_per_s"),
           1e-6 * number(device, "points"), 100.0 * number(packets, "lost_share"), number(packets, "gaps"),
           number(device["clock"], "drift_ppm"), number(device["clock"], "jitter_us"));
  }
  for (const Inspection& device : devices) {
    if (!device.contains("control_frames")) continue;
    append(text, "commands of %s:", device_name(device).c_str());
    append_counts(text, device["control_frames"]);
  }
}

void append_streams(std::string& text, const Inspection& devices) {
  append(text, "%-16s %-6s %9s %9s %7s %8s %7s %8s %7s  %s\n", "packets", "stream", "expected", "received", "lost",
         "twice", "order", "damaged", "gaps", "longest gap");
  for (const Inspection& device : devices) {
    const std::string name = device_name(device);
    for (const char* stream : {"point", "imu"}) {
      const Inspection& book = device[std::string(stream) + "_packets"];
      if (number(book, "packets") + number(book, "damaged") == 0.0) continue;
      append(text, "%-16s %-6s %9.0f %9.0f %7.0f %8.0f %7.0f %8.0f %7.0f", name.c_str(), stream,
             number(book, "expected"), number(book, "packets"), number(book, "lost"), number(book, "duplicates"),
             number(book, "out_of_order"), number(book, "damaged"), number(book, "gaps"));
      const Inspection& longest = book["longest_gap"];
      if (number(longest, "packets") > 0.0) {
        append(text, "  %.2f ms at %.6f s", 1e3 * number(longest, "seconds"),
               seconds_of_ns(longest["start_ns"].get<std::int64_t>()));
      }
      text += "\n";
    }
  }
}

void append_images(std::string& text, const Inspection& images) {
  for (const auto& [camera, count] : images.items()) {
    append(text, "images of %s: %.0f\n", camera.c_str(), number(count, "files"));
  }
}

void append_file_extrinsics(std::string& text, const Inspection& extrinsics) {
  for (const Inspection& device : extrinsics) {
    const auto angles = device["roll_pitch_yaw_deg"].get<std::vector<double>>();
    const auto shift = device["translation"].get<std::vector<double>>();
    append(text, "the file puts %s at roll %.3f, pitch %.3f, yaw %.3f deg, t [%.4f, %.4f, %.4f] m%s: not used\n",
           device["broadcast_code"].get<std::string>().c_str(), angles[0], angles[1], angles[2], shift[0], shift[1],
           shift[2], device["in_use"].get<bool>() ? "" : " (switched off)");
  }
}

void append_topics(std::string& text, const Inspection& topics) {
  append(text, "%-16s %-32s %-30s %9s %9s %9s %7s\n", "sensor", "topic", "type", "seconds", "per s", "points", "lost");
  for (const Inspection& topic : topics) {
    append(text, "%-16s %-32s %-30s %9.1f %9.1f %8.2fM %7.0f\n", topic.value("sensor", "-").c_str(),
           topic["topic"].get<std::string>().c_str(), topic["type"].get<std::string>().c_str(),
           number(topic, "seconds"), number(topic, "messages_per_s"), 1e-6 * number(topic, "points"),
           number(topic, "lost"));
  }
}

void append_stops(std::string& text, const Inspection& stops) {
  if (stops.empty()) {
    text += "no stops\n";
    return;
  }
  const bool timed = stops[0].contains("start_ns");
  const std::int64_t first_ns = timed ? stops[0]["start_ns"].get<std::int64_t>() : 0;
  text += timed ? "stop  start s  length s  turned deg  points\n" : "stop  points\n";
  for (const Inspection& stop : stops) {
    append(text, "%4d", stop["stop"].get<int>());
    if (timed) {
      append(text, " %8.2f %9.2f", seconds_of_ns(stop["start_ns"].get<std::int64_t>() - first_ns),
             number(stop, "seconds"));
      if (stop["turn_known"].get<bool>()) {
        append(text, " %11.2f", number(stop, "turned_deg"));
      } else {
        append(text, " %11s", "unknown");
      }
    }
    append_counts(text, stop["points"]);
  }
}

void append_gyro(std::string& text, const Inspection& gyro) {
  append(text, "gyro: %.0f readings, noise %.3f deg/s, longest rest %.2f s\n", number(gyro, "samples"),
         number(gyro, "noise_deg_s"), number(gyro, "longest_rest_s"));
}

void append_source(std::string& text, const Inspection& inspection) {
  const bool gyro = inspection["stops_from"] == "gyro";
  const Inspection& view = inspection["view"];
  append(text, "stops found from the %s", gyro ? "gyro, the points watch for creep" : "points");
  if (number(view, "resolution_deg") > 0.0) {
    append(text, "; they show turns from %.3f deg on in a quarter of a second", number(view, "resolution_deg"));
  }
  if (number(view, "blind_s") > 0.0) append(text, "; too few surfaces to tell for %.1f s", number(view, "blind_s"));
  text += "\n";
}

void append_kept(std::string& text, const Inspection& points) {
  append(text, "points in stops: %.0f; dropped:", number(points, "in_stops"));
  for (const auto& [reason, count] : points["dropped"].items()) {
    if (count.get<std::uint64_t>() > 0) append(text, " %s %.0f", reason.c_str(), count.get<double>());
  }
  text += "\n";
}

void append_sensors(std::string& text, const Inspection& sensors) {
  for (const Inspection& sensor : sensors) {
    append(text, "%-16s %-7s", sensor["name"].get<std::string>().c_str(), sensor.value("status", "").c_str());
    if (sensor.contains("translation")) {
      const auto t = sensor["translation"].get<std::vector<double>>();
      const auto q = sensor["rotation_xyzw"].get<std::vector<double>>();
      append(text, " t [%.4f, %.4f, %.4f] m, q [%.5f, %.5f, %.5f, %.5f]", t[0], t[1], t[2], q[0], q[1], q[2], q[3]);
    }
    if (sensor.contains("stddev_mm")) {
      const auto mm = sensor["stddev_mm"].get<std::vector<double>>();
      const auto deg = sensor["stddev_deg"].get<std::vector<double>>();
      append(text, ", sigma [%.2f, %.2f, %.2f] mm, [%.4f, %.4f, %.4f] deg", mm[0], mm[1], mm[2], deg[0], deg[1],
             deg[2]);
    }
    text += "\n";
    if (sensor.contains("bounds")) text += "    " + sensor["bounds"].get<std::string>() + "\n";
    if (!sensor.contains("reasons")) continue;
    for (const Inspection& reason : sensor["reasons"]) text += "    - " + reason.get<std::string>() + "\n";
  }
}

void append_moves(std::string& text, const Inspection& moves) {
  for (const Inspection& move : moves) {
    append(text, "%-16s %-12s", move["name"].get<std::string>().c_str(), move["verdict"].get<std::string>().c_str());
    if (move.contains("why_not")) {
      text += " " + move["why_not"].get<std::string>();
    } else {
      append(text, " %8.2f mm %8.4f deg  %6.1f times the joint sigma", number(move, "translation_mm"),
             number(move, "rotation_deg"), number(move, "sigmas"));
    }
    text += "\n";
  }
}

}  // namespace

std::string inspection_text(const Inspection& inspection) {
  std::string text = inspection["path"].get<std::string>() + ": a " + inspection["kind"].get<std::string>() + "\n";
  if (inspection["kind"] == "patches") text.replace(text.rfind("a patches"), 9, "a patch folder");
  if (inspection["kind"] == "comparison")
    text = text.substr(0, text.rfind(": a ")) + " and " + inspection["other"].get<std::string>() + "\n";
  if (inspection.contains("verdict")) {
    text += (inspection.contains("status") ? inspection["status"].get<std::string>() + ": " : std::string()) +
            inspection["verdict"].get<std::string>() + "\n";
  }
  if (inspection.contains("base")) text += "base: " + inspection["base"].get<std::string>() + "\n";
  if (inspection.contains("devices")) {
    append_devices(text, inspection["devices"]);
    append_streams(text, inspection["devices"]);
  }
  if (inspection.contains("file_extrinsics")) append_file_extrinsics(text, inspection["file_extrinsics"]);
  if (inspection.contains("topics")) append_topics(text, inspection["topics"]);
  if (inspection.contains("gyro")) append_gyro(text, inspection["gyro"]);
  if (inspection.contains("stops_from")) append_source(text, inspection);
  if (inspection.contains("stops")) append_stops(text, inspection["stops"]);
  if (inspection.contains("images")) append_images(text, inspection["images"]);
  if (inspection.contains("points")) append_kept(text, inspection["points"]);
  if (inspection.contains("sensors")) append_sensors(text, inspection["sensors"]);
  if (inspection.contains("moves")) append_moves(text, inspection["moves"]);
  return text;
}

}  // namespace rigcal
