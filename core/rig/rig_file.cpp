#include "core/rig/rig_file.h"

#include <utility>

#include "core/rig/text_file.h"
#include "core/rig/yaml_tree.h"

namespace rigcal {

Expected<RigFile> load_rig_file(const std::string& path) {
  Expected<std::string> text = read_text_file(path, YamlLimits{}.max_bytes);
  if (!text) return text.error();
  Expected<Rig> rig = parse_rig(*text, path);
  if (!rig) return rig.error();
  return RigFile{*std::move(text), *std::move(rig)};
}

}  // namespace rigcal
