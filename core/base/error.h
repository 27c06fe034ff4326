#pragma once

#include <string>
#include <utility>
#include <variant>

namespace rigcal {

/// Who can mend it; `apps` maps this to the exit code.
enum class ErrorKind {
  input,      ///< A file or stream is missing, unreadable, damaged or contradictory (exit code 3).
  system,     ///< A device, the network or the system refused (exit code 4).
  cancelled,  ///< The user stopped the work; nothing is wrong.
};

/// What went wrong, where (file and line, or packet and offset) and how to mend it. Each part is one clause
/// without a full stop; `where` and `mend` may be empty.
struct Error {
  ErrorKind kind = ErrorKind::input;
  std::string what;
  std::string where;
  std::string mend;

  /// "where: what; mend", the one line a user sees.
  [[nodiscard]] std::string message() const;
};

[[nodiscard]] Error input_error(std::string what, std::string where = {}, std::string mend = {});
[[nodiscard]] Error system_error(std::string what, std::string where = {}, std::string mend = {});
/// Of what somebody stopped: no fault of anything.
[[nodiscard]] Error cancelled_error(std::string what = "stopped", std::string where = {});

/// A value or the Error that kept it from being made. Reading the part that is not there aborts with the error's text.
template <class T>
class [[nodiscard]] Expected {
 public:
  Expected(T value) : content_(std::in_place_index<0>, std::move(value)) {}
  Expected(Error error) : content_(std::in_place_index<1>, std::move(error)) {}

  [[nodiscard]] bool has_value() const { return content_.index() == 0; }
  explicit operator bool() const { return has_value(); }

  [[nodiscard]] T& value() &;
  [[nodiscard]] const T& value() const&;
  [[nodiscard]] T&& value() &&;
  [[nodiscard]] T& operator*() & { return value(); }
  [[nodiscard]] const T& operator*() const& { return value(); }
  [[nodiscard]] T&& operator*() && { return std::move(*this).value(); }
  [[nodiscard]] T* operator->() { return &value(); }
  [[nodiscard]] const T* operator->() const { return &value(); }
  [[nodiscard]] const Error& error() const;

 private:
  std::variant<T, Error> content_;
};

/// Nothing, or an Error.
template <>
class [[nodiscard]] Expected<void> {
 public:
  Expected() = default;
  Expected(Error error) : error_(std::move(error)), failed_(true) {}

  [[nodiscard]] bool has_value() const { return !failed_; }
  explicit operator bool() const { return has_value(); }
  [[nodiscard]] const Error& error() const;

 private:
  Error error_;
  bool failed_ = false;
};

/// Ends the program: a mistake of ours, never of the input. Checked in every build.
[[noreturn]] void abort_with(const std::string& message, const char* file, int line);

#define RIGCAL_ASSERT(condition, message) \
  ((condition) ? static_cast<void>(0) : ::rigcal::abort_with((message), __FILE__, __LINE__))

template <class T>
T& Expected<T>::value() & {
  RIGCAL_ASSERT(has_value(), "no value: " + std::get<1>(content_).message());
  return std::get<0>(content_);
}

template <class T>
const T& Expected<T>::value() const& {
  RIGCAL_ASSERT(has_value(), "no value: " + std::get<1>(content_).message());
  return std::get<0>(content_);
}

template <class T>
T&& Expected<T>::value() && {
  RIGCAL_ASSERT(has_value(), "no value: " + std::get<1>(content_).message());
  return std::get<0>(std::move(content_));
}

template <class T>
const Error& Expected<T>::error() const {
  RIGCAL_ASSERT(!has_value(), "no error in an Expected that holds a value");
  return std::get<1>(content_);
}

}  // namespace rigcal
