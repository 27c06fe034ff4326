#pragma once

#include <string>

#include "core/quality/verdict.h"

namespace rigcal {

/// Numbers as the reasons write them.
[[nodiscard]] std::string number(double value, int digits);
[[nodiscard]] std::string mm(double m);
[[nodiscard]] std::string deg(double rad);

/// The reason why no sensor is better than weak where the table's steps were assumed (see Start).
[[nodiscard]] std::string assumed_steps_words();

/// The reason why nothing can be told against a base that saw nothing.
[[nodiscard]] std::string blind_base_words(const std::string& base);

void fail(Verdict& verdict, std::string reason);
/// A failed one stays failed.
void weaken(Verdict& verdict, std::string reason);

}  // namespace rigcal
