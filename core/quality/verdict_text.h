#pragma once

#include <string>

#include "core/quality/verdict.h"

namespace rigcal {

/// Numbers as the reasons write them.
[[nodiscard]] std::string number(double value, int digits);
[[nodiscard]] std::string mm(double m);
[[nodiscard]] std::string deg(double rad);

void fail(Verdict& verdict, std::string reason);
/// A failed one stays failed.
void weaken(Verdict& verdict, std::string reason);

}  // namespace rigcal
