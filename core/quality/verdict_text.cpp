#include "core/quality/verdict_text.h"

#include <utility>

#include "core/base/text.h"

namespace rigcal {

std::string number(double value, int digits) { return fixed_text(value, digits); }

std::string mm(double m) { return number(1e3 * m, 1) + " mm"; }
std::string deg(double rad) { return number(to_deg(rad), 3) + " degrees"; }

std::string assumed_steps_words() {
  return "too little was seen from two stops to find how far the table turned between them: they were placed as if it "
         "had turned all round in equal steps, and sigma does not hold where steps were off that by more than some "
         "degrees, nor in a bare room; record more stops in smaller, equal turns, or with a gyro";
}

std::string blind_base_words(const std::string& base) {
  return base +
         ", the base, has no points in any stop that could be used, so that nothing can be told against it; see why it "
         "has none, "
         "or name another base in the rig file";
}

void fail(Verdict& verdict, std::string reason) {
  verdict.status = Status::failed;
  verdict.reasons.push_back(std::move(reason));
}

void weaken(Verdict& verdict, std::string reason) {
  if (verdict.status == Status::good) verdict.status = Status::weak;
  verdict.reasons.push_back(std::move(reason));
}

}  // namespace rigcal
