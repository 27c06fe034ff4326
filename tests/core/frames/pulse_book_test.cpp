#include "core/frames/pulse_book.h"

#include <gtest/gtest.h>

namespace rigcal {
namespace {

constexpr std::int64_t ms = 1'000'000;
using Verdict = PulseChoice::Verdict;

PulseBook book_of(std::initializer_list<std::int64_t> stamps_ms) {
  PulseBook book;
  std::int64_t number = 0;
  for (const std::int64_t stamp : stamps_ms) book.add({number++, stamp * ms});
  return book;
}

TEST(PulseBook, ChoosesThePulseAtATime) {
  const PulseBook book = book_of({100, 150, 200});
  const PulseChoice choice = book.choose({150 * ms + 300'000, 200e3});
  EXPECT_EQ(choice.verdict, Verdict::clear);
  EXPECT_EQ(choice.index, 1U);
  EXPECT_EQ(book.choose({99 * ms, 200e3}).index, 0U);
  EXPECT_EQ(book.choose({201 * ms, 200e3}).index, 2U);
}

TEST(PulseBook, HasNoneForATimeBetween) {
  EXPECT_EQ(book_of({100, 150, 200}).choose({125 * ms, 200e3}).verdict, Verdict::none);
  EXPECT_EQ(book_of({}).choose({125 * ms, 200e3}).verdict, Verdict::none);
}

TEST(PulseBook, DoesNotChooseBetweenPulsesThatAreTooClose) {
  const PulseBook book = book_of({100, 101, 102});
  EXPECT_EQ(book.choose({101 * ms, 1e6}).verdict, Verdict::several);
  EXPECT_EQ(book.choose({101 * ms, 100e3}).verdict, Verdict::clear);
  EXPECT_EQ(book.choose({101 * ms + 450'000, 100e3}).verdict, Verdict::several);
}

TEST(PulseBook, GoesRoundInItsMemory) {
  PulseBook book;
  for (std::int64_t i = 0; i < 10'000; ++i) {
    if (book.is_full()) book.drop_first();
    book.add({i, i * 10 * ms});
    if (i % 2 == 0) book.take(book.size() - 1);
  }
  EXPECT_EQ(book.size(), PulseBook::kCapacity);
  const std::size_t index = book.first_from(99'990 * ms);
  EXPECT_EQ(book.pulse(index).pulse, 9999);
  EXPECT_FALSE(book.is_taken(index));
  EXPECT_TRUE(book.is_taken(index - 1));
  EXPECT_EQ(book.first_from(99'991 * ms), book.size());
  EXPECT_EQ(book.first_from(0), 0U);
}

}  // namespace
}  // namespace rigcal
