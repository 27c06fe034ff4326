// What every camera keeps, whatever it hangs on. One suite for all back ends: see contract.h.
#include "tests/drivers/camera/contract.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <ctime>
#include <set>

#include "tests/support/allocation_counter.h"

namespace rigcal::camera {
namespace {

using testing::HasSubstr;
using Kind = Delivery::Kind;

constexpr std::int64_t ms = 1'000'000;
constexpr std::int64_t patience = 10'000 * ms;  ///< The tests' machine may be busy with something else.

std::int64_t monotonic_ns() {
  timespec time{};
  clock_gettime(CLOCK_MONOTONIC, &time);
  return time.tv_sec * std::int64_t{1'000'000'000} + time.tv_nsec;
}

class CameraContract : public testing::TestWithParam<SubjectMaker> {
 protected:
  void SetUp() override {
    std::string reason;
    subject = GetParam().make(reason);
    if (!subject) GTEST_SKIP() << "NOT TESTED: " << reason;
    camera = subject->backend().make();
  }
  /// A camera that was just made is brought there.
  void bring(Camera& fresh, CameraState state, const CameraConfig& config) {
    if (state >= CameraState::open) {
      const auto opened = fresh.open(subject->name());
      ASSERT_TRUE(opened.has_value()) << opened.error().message();
    }
    if (state >= CameraState::configured) {
      const auto configured = fresh.configure(config);
      ASSERT_TRUE(configured.has_value()) << configured.error().message();
      setup = *configured;
    }
    if (state >= CameraState::streaming) {
      const auto started = fresh.start();
      ASSERT_TRUE(started.has_value()) << started.error().message();
    }
    ASSERT_EQ(fresh.state(), state);
  }
  void bring(CameraState state) { bring(*camera, state, subject->config()); }
  /// The next delivery; an error is none.
  Delivery next(std::int64_t timeout_ns = patience) {
    Expected<Delivery> delivery = camera->next(timeout_ns);
    EXPECT_TRUE(delivery.has_value()) << delivery.error().message();
    return delivery ? *std::move(delivery) : Delivery{};
  }
  /// The next whole frame. On a busy machine a part of one may be all that comes in time: such frames are counted.
  Frame frame() {
    not_whole_before = 0;
    for (;;) {
      Delivery delivery = next();
      EXPECT_EQ(delivery.kind, Kind::frame);
      if (delivery.kind != Kind::frame || delivery.frame.is_whole()) return std::move(delivery.frame);
      EXPECT_EQ(delivery.frame.facts().status, FrameStatus::incomplete);
      not_whole_before += 1 + delivery.frame.facts().missing_before;
      if (++not_whole > subject->most_not_whole()) {
        ADD_FAILURE() << not_whole << " frames were not whole";
        return {};
      }
    }
  }
  Expected<void> call(Camera& of, CameraCall which) {
    const auto plain = [](const auto& expected) {
      return expected ? Expected<void>() : Expected<void>(expected.error());
    };
    switch (which) {
      case CameraCall::open:
        return of.open(subject->name());
      case CameraCall::configure:
        return plain(of.configure(subject->config()));
      case CameraCall::start:
        return of.start();
      case CameraCall::next:
        return plain(of.next(0));
      case CameraCall::trigger:
        return of.trigger();
      case CameraCall::stop:
        return of.stop();
      case CameraCall::close:
        break;
    }
    of.close();
    return {};
  }
  CameraConfig triggered() const {
    CameraConfig config = subject->config();
    config.trigger = TriggerConfig{"Software", false, 0.0};
    return config;
  }

  std::unique_ptr<ContractSubject> subject;
  std::unique_ptr<Camera> camera;
  CameraSetup setup;
  std::uint64_t not_whole = 0;         ///< Of all frames so far.
  std::uint64_t not_whole_before = 0;  ///< Between the last two whole ones, with those that never came.
};

TEST_P(CameraContract, ACallThatIsNotLegalIsAnErrorAndChangesNothing) {
  for (const CameraState state : kAllStates) {
    camera = subject->backend().make();
    ASSERT_NO_FATAL_FAILURE(bring(state));
    for (const CameraCall which : kAllCalls) {
      if (is_legal(which, state)) continue;
      const Expected<void> done = call(*camera, which);
      ASSERT_FALSE(done.has_value()) << to_string(which) << " while " << to_string(state);
      EXPECT_THAT(done.error().message(), HasSubstr(to_string(which)));
      EXPECT_THAT(done.error().message(), HasSubstr(to_string(state)));
      EXPECT_FALSE(done.error().mend.empty());
      EXPECT_EQ(camera->state(), state);
    }
    if (state == CameraState::streaming) {
      EXPECT_TRUE(frame().is_whole());
    }
  }
}

TEST_P(CameraContract, ACallThatIsLegalLeadsWhereItShould) {
  const std::vector<std::pair<CameraCall, CameraState>> way{
      {CameraCall::close, CameraState::closed},
      {CameraCall::open, CameraState::open},
      {CameraCall::configure, CameraState::configured},
      {CameraCall::configure, CameraState::configured},
      {CameraCall::start, CameraState::streaming},
      {CameraCall::next, CameraState::streaming},
      {CameraCall::stop, CameraState::configured},
      {CameraCall::configure, CameraState::configured},
      {CameraCall::start, CameraState::streaming},
      {CameraCall::close, CameraState::closed},
      {CameraCall::open, CameraState::open},
      {CameraCall::close, CameraState::closed},
  };
  for (const auto& [which, state] : way) {
    const Expected<void> done = call(*camera, which);
    ASSERT_TRUE(done.has_value()) << to_string(which) << ": " << done.error().message();
    EXPECT_EQ(camera->state(), state);
  }
}

TEST_P(CameraContract, IsFoundByEachOfItsNames) {
  const auto there = subject->backend().enumerate();
  ASSERT_TRUE(there.has_value()) << there.error().message();
  const auto it = std::find_if(there->begin(), there->end(),
                               [&](const CameraIdentity& identity) { return identity.id == subject->camera(); });
  ASSERT_NE(it, there->end());
  for (const std::string& name : {it->id, it->address, it->serial}) {
    if (name.empty()) continue;
    const auto opened = camera->open(name);
    ASSERT_TRUE(opened.has_value()) << opened.error().message();
    EXPECT_EQ(camera->identity().id, it->id);
    EXPECT_EQ(camera->identity().address, it->address);
    EXPECT_EQ(camera->identity().link, it->link);
    camera->close();
  }
}

TEST_P(CameraContract, AnAbsentCameraIsAnErrorThatSaysWhichAreThere) {
  const auto opened = camera->open("no-such-camera-4711");
  ASSERT_FALSE(opened.has_value());
  EXPECT_THAT(opened.error().message(), HasSubstr("no-such-camera-4711"));
  EXPECT_THAT(opened.error().message(), HasSubstr(subject->camera()));
  EXPECT_EQ(camera->state(), CameraState::closed);
  bring(CameraState::open);
}

TEST_P(CameraContract, AFormatThatItLacksIsAnErrorThatSaysWhichItHas) {
  bring(CameraState::open);
  CameraConfig config = subject->config();
  config.pixel_format = subject->missing_format();
  const auto refused = camera->configure(config);
  ASSERT_FALSE(refused.has_value());
  EXPECT_THAT(refused.error().message(), HasSubstr(subject->missing_format()));
  EXPECT_EQ(camera->state(), CameraState::open);
  const auto configured = camera->configure(subject->config());
  ASSERT_TRUE(configured.has_value()) << configured.error().message();
  EXPECT_THAT(refused.error().message(), HasSubstr(configured->pixel_format));
}

TEST_P(CameraContract, WhatNoCameraCanDoIsRefused) {
  bring(CameraState::open);
  const auto refused = [&](const auto& spoil) {
    CameraConfig config = subject->config();
    spoil(config);
    return !camera->configure(config).has_value();
  };
  EXPECT_TRUE(refused([](CameraConfig& config) { config.buffers = 1; }));
  EXPECT_TRUE(refused([](CameraConfig& config) { config.buffers = 1'000'000; }));
  EXPECT_TRUE(refused([](CameraConfig& config) { config.exposure_us = -1.0; }));
  EXPECT_TRUE(refused([](CameraConfig& config) { config.frame_rate = 0.0; }));
  EXPECT_TRUE(refused([](CameraConfig& config) { config.trigger = TriggerConfig{}; }));
  EXPECT_TRUE(refused([](CameraConfig& config) { config.region = Region{0, 0, 1'000'000, 1'000'000}; }));
  EXPECT_TRUE(refused([](CameraConfig& config) { config.region = Region{-8, 0, 64, 48}; }));
  EXPECT_FALSE(refused([](CameraConfig&) {}));
}

TEST_P(CameraContract, FramesComeInOrderAndAsTheyWereSetUp) {
  bring(CameraState::streaming);
  std::optional<FrameFacts> before;
  for (int i = 0; i < 2; ++i) frame();  // Some drivers number the first two alike.
  for (int i = 0; i < 12; ++i) {
    const Frame lent = frame();
    const FrameFacts facts = lent.facts();
    ASSERT_TRUE(lent.is_whole());
    EXPECT_EQ(facts.width, setup.width);
    EXPECT_EQ(facts.height, setup.height);
    EXPECT_EQ(facts.pixel_format, setup.pixel_format);
    EXPECT_EQ(lent.pixels().size(), setup.image_bytes);
    EXPECT_EQ(facts.row_bytes * static_cast<std::size_t>(facts.height), lent.pixels().size());
    EXPECT_EQ(facts.device_stamp_ns.has_value(), setup.has_device_stamps);
    // The kernel may foretell a frame's end.
    EXPECT_LE(facts.host_stamp_ns, monotonic_ns() + (setup.host_stamp == HostStamp::arrival_end ? 200 * ms : 0));
    EXPECT_GT(facts.host_stamp_ns, monotonic_ns() - 2 * patience);
    if (before) {
      EXPECT_EQ(facts.frame_id, before->frame_id + 1 + facts.missing_before + not_whole_before);
      EXPECT_GT(facts.host_stamp_ns, before->host_stamp_ns);
      if (facts.device_stamp_ns) {
        EXPECT_GT(*facts.device_stamp_ns, *before->device_stamp_ns);
      }
    }
    before = facts;
  }
  EXPECT_EQ(camera->counters().whole(), 14U);
  EXPECT_EQ(camera->counters().damaged(), not_whole);
}

TEST_P(CameraContract, BuffersAreUsedAgain) {
  CameraConfig config = subject->config();
  config.buffers = 4;
  bring(*camera, CameraState::streaming, config);
  std::set<const std::uint8_t*> places;
  for (int i = 0; i < 16; ++i) places.insert(frame().pixels().data());
  EXPECT_LE(places.size(), 4U);
}

TEST_P(CameraContract, FramesThatFindNoBufferAreCounted) {
  CameraConfig config = subject->config();
  config.buffers = 3;
  bring(*camera, CameraState::streaming, config);
  const auto lost = [&] { return camera->counters().missing + camera->counters().no_buffer; };
  std::uint64_t taken = 0;
  // On a busy machine a camera may send no more than a part of a frame meanwhile.
  for (int round = 0; round < 5 && lost() == 0; ++round) {
    std::vector<Frame> lent;
    for (int i = 0; i < 3; ++i) lent.push_back(frame());
    const std::vector<std::uint8_t> pixels(lent[0].pixels().begin(), lent[0].pixels().end());
    EXPECT_EQ(next(400 * ms).kind, Kind::nothing);
    EXPECT_TRUE(std::equal(pixels.begin(), pixels.end(), lent[0].pixels().begin()));
    lent.clear();
    // Where it goes on after the buffers are back, that frame is damaged, but none after it.
    Delivery after = next();
    if (after.kind == Kind::frame && after.frame.facts().status == FrameStatus::incomplete) after = next();
    ASSERT_EQ(after.kind, Kind::frame);
    EXPECT_TRUE(after.frame.is_whole());
    taken += 4;
  }
  EXPECT_GT(lost(), 0U);
  EXPECT_EQ(camera->counters().whole(), taken);
}

TEST_P(CameraContract, ALentFrameOutlivesTheCamera) {
  bring(CameraState::streaming);
  Frame lent = frame();
  const std::vector<std::uint8_t> pixels(lent.pixels().begin(), lent.pixels().end());
  const std::string format(lent.facts().pixel_format);
  ASSERT_TRUE(camera->stop().has_value());
  EXPECT_TRUE(std::equal(pixels.begin(), pixels.end(), lent.pixels().begin()));
  camera.reset();
  EXPECT_TRUE(std::equal(pixels.begin(), pixels.end(), lent.pixels().begin()));
  EXPECT_EQ(lent.facts().pixel_format, format);
  lent.give_back();
  EXPECT_TRUE(lent.pixels().empty());
  EXPECT_FALSE(lent.is_whole());
}

TEST_P(CameraContract, StartsAgainAndAgain) {
  bring(CameraState::streaming);
  for (int i = 0; i < 3; ++i) {
    EXPECT_TRUE(frame().is_whole());
    ASSERT_TRUE(camera->stop().has_value());
    const auto started = camera->start();
    ASSERT_TRUE(started.has_value()) << started.error().message();
  }
  EXPECT_TRUE(frame().is_whole());
  camera->close();
  bring(CameraState::streaming);
  EXPECT_TRUE(frame().is_whole());
  EXPECT_EQ(camera->counters().whole(), 5U);
}

TEST_P(CameraContract, SendsAPartOfTheSensor) {
  CameraConfig config = subject->config();
  config.region = subject->part();
  if (!config.region) GTEST_SKIP() << "this camera has no parts";
  bring(*camera, CameraState::streaming, config);
  const Frame lent = frame();
  EXPECT_EQ(lent.facts().width, config.region->width);
  EXPECT_EQ(lent.facts().height, config.region->height);
  EXPECT_EQ(lent.pixels().size(), setup.image_bytes);
}

TEST_P(CameraContract, ATriggerBySoftwareIsAFrame) {
  if (!subject->has_software_trigger()) {
    bring(CameraState::open);
    EXPECT_FALSE(camera->configure(triggered()).has_value());
    return;
  }
  bring(*camera, CameraState::streaming, triggered());
  EXPECT_EQ(next(200 * ms).kind, Kind::nothing);
  for (int i = 0; i < 4; ++i) {
    const auto triggered = camera->trigger();
    ASSERT_TRUE(triggered.has_value()) << triggered.error().message();
    EXPECT_TRUE(frame().is_whole());
  }
  EXPECT_EQ(next(200 * ms).kind, Kind::nothing);
}

TEST_P(CameraContract, ATriggerOfACameraThatRunsFreeIsAnError) {
  bring(CameraState::streaming);
  const auto triggered = camera->trigger();
  ASSERT_FALSE(triggered.has_value());
  EXPECT_THAT(triggered.error().message(), HasSubstr("Software"));
}

TEST_P(CameraContract, NothingIsAllocatedForAFrame) {
  if (subject->allocates_for_frames()) GTEST_SKIP() << "decodes its images";
  bring(CameraState::streaming);
  for (int i = 0; i < 4; ++i) frame();
  std::uint64_t before = allocations_in_this_thread();
  for (int i = 0; i < 10; ++i) {
    const Expected<Delivery> delivery = camera->next(patience);
    if (!delivery || delivery->kind != Kind::frame) before = 0;
  }
  EXPECT_EQ(allocations_in_this_thread(), before);
}

TEST_P(CameraContract, IsDestroyedInAnyStateAndCanBeHadAgain) {
  for (const CameraState state : kAllStates) {
    auto other = subject->backend().make();
    ASSERT_NO_FATAL_FAILURE(bring(*other, state, subject->config()));
  }
  bring(CameraState::streaming);
  EXPECT_TRUE(frame().is_whole());
}

INSTANTIATE_TEST_SUITE_P(Camera, CameraContract, testing::ValuesIn(subjects()),
                         [](const auto& subject) { return subject.param.name; });

}  // namespace
}  // namespace rigcal::camera
