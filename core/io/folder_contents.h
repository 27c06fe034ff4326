#pragma once

#include <string>

#include "core/base/error.h"

namespace rigcal {

/// Whether a folder cannot make room for another one without harm: it is what a file system is mounted on (a volume of
/// a container), or some program stands in it or below (the shell after `cd result`, a web server that shows it) and
/// would be left in a folder that is gone. Programs of other users may go unseen. `folder` is absolute, links followed.
[[nodiscard]] bool must_stay(const std::string& folder);

/// The same for what is mounted alone.
[[nodiscard]] bool is_mounted(const std::string& folder);

/// Replaces the files of `folder`, at any depth, by those of `fresh`, a folder of the same file system; folders that
/// both have stay. `first` (a name in the folder) is the first that goes and the last that comes, so that where it is,
/// all the others are that belong to it. `fresh` may stand within `folder`; hidden entries of `folder` are left alone.
/// After an Error all is as before; after success `fresh` is gone.
[[nodiscard]] Expected<void> replace_contents(const std::string& folder, const std::string& fresh,
                                              const std::string& first);

}  // namespace rigcal
