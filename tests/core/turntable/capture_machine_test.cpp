#include "core/turntable/capture_machine.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>

namespace rigcal {
namespace {

using namespace happened;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using State = CaptureState;
using Action = CaptureAction;
using Actions = std::vector<CaptureAction>;

constexpr int lidar = 0;
constexpr int camera = 1;

CaptureGoal goal(bool turns_itself = false) {
  CaptureGoal goal;
  goal.stops = 2;
  goal.dwell_s = 1.0;
  goal.check_s = 10.0;
  goal.frame_s = 3.0;
  goal.table_s = 20.0;
  goal.turns_itself = turns_itself;
  return goal;
}

/// A machine of a LiDAR and a camera, and a clock.
class Machine {
 public:
  explicit Machine(const CaptureGoal& wanted) : machine(wanted, {{"lidar", false}, {"camera", true}}) {}
  Actions tell(const CaptureInput& input, double after_s = 0.0) {
    now_s += after_s;
    return machine.handle(now_s, input);
  }
  State state() const { return machine.state(); }
  CaptureProgress progress() const { return machine.progress(); }

  Machine& begin() {
    EXPECT_THAT(tell(Begun{}), IsEmpty());
    EXPECT_THAT(tell(SensorCame{lidar}), IsEmpty());
    EXPECT_THAT(tell(SensorCame{camera}), IsEmpty());
    return *this;
  }
  Machine& settle(int stop) {
    EXPECT_THAT(tell(RestBegan{}), IsEmpty());
    EXPECT_THAT(tell(RestSettled{stop, now_s}), IsEmpty());
    return *this;
  }
  /// What comes of the stop's being full.
  Actions fill() {
    EXPECT_THAT(tell(ImageCame{camera}), IsEmpty());
    EXPECT_THAT(tell(Rested{0.6}), IsEmpty());
    return tell(Rested{1.0});
  }
  Machine& leave(int stop, double seconds) {
    EXPECT_THAT(tell(StopOver{stop, seconds}), IsEmpty());
    EXPECT_THAT(tell(RestOver{}), IsEmpty());
    return *this;
  }

 private:
  CaptureMachine machine;
  double now_s = 100.0;
};

TEST(CaptureMachine, AWholeRunByHand) {
  Machine run(goal());
  EXPECT_EQ(run.state(), State::idle);
  EXPECT_THAT(run.tell(Begun{}), IsEmpty());
  EXPECT_EQ(run.state(), State::checking);
  EXPECT_THAT(run.progress().absent, ElementsAre("lidar", "camera"));
  run.tell(SensorCame{camera});
  EXPECT_EQ(run.state(), State::checking);
  run.tell(SensorCame{lidar});
  EXPECT_EQ(run.state(), State::waiting_for_still);
  run.tell(RestBegan{});
  EXPECT_EQ(run.state(), State::settling);
  run.tell(RestSettled{0});
  EXPECT_EQ(run.state(), State::capturing);
  EXPECT_THAT(run.progress().awaited, ElementsAre("camera"));
  EXPECT_THAT(run.fill(), ElementsAre(Action::secure));
  EXPECT_EQ(run.state(), State::capturing);
  EXPECT_TRUE(run.progress().is_full);
  EXPECT_EQ(run.progress().stops, 1);
  run.leave(0, 1.4);
  EXPECT_EQ(run.state(), State::moving);
  EXPECT_EQ(run.progress().stops, 1);
  run.settle(1);
  EXPECT_EQ(run.state(), State::capturing);
  EXPECT_EQ(run.progress().stop, 1);
  EXPECT_THAT(run.fill(), ElementsAre(Action::secure, Action::end));
  EXPECT_EQ(run.state(), State::ended);
  EXPECT_EQ(run.progress().short_stops, 0);
}

TEST(CaptureMachine, SensorsThatDoNotComeAreGoneWithout) {
  Machine run(goal());
  run.tell(Begun{});
  run.tell(SensorCame{lidar});
  run.tell(TimePassed{}, 9.9);
  EXPECT_EQ(run.state(), State::checking);
  run.tell(TimePassed{}, 0.1);
  EXPECT_EQ(run.state(), State::waiting_for_still);
  EXPECT_THAT(run.progress().absent, ElementsAre("camera"));
  run.settle(0);
  EXPECT_THAT(run.tell(Rested{1.0}), ElementsAre(Action::secure));  // Without its image.
}

TEST(CaptureMachine, ARigThatRestsWhileItIsCheckedIsCapturedAtOnce) {
  Machine run(goal());
  run.tell(Begun{});
  run.tell(RestBegan{});
  run.tell(RestSettled{0});
  run.tell(ImageCame{camera});
  run.tell(Rested{5.0});
  EXPECT_EQ(run.state(), State::checking);
  run.tell(SensorCame{lidar});
  EXPECT_THAT(run.tell(SensorCame{camera}), ElementsAre(Action::secure));
  EXPECT_EQ(run.state(), State::capturing);
  EXPECT_EQ(run.progress().stops, 1);
}

TEST(CaptureMachine, ARestThatIsTooShortIsNoStop) {
  Machine run(goal());
  run.begin();
  run.tell(RestBegan{});
  run.tell(RestOver{});
  EXPECT_EQ(run.state(), State::waiting_for_still);
  run.settle(0).fill();
  run.leave(0, 1.5);
  run.tell(RestBegan{});
  EXPECT_EQ(run.state(), State::settling);
  run.tell(RestOver{});
  EXPECT_EQ(run.state(), State::moving);  // There is a stop behind it.
}

TEST(CaptureMachine, AStopThatIsLeftEarlyDoesNotCount) {
  Machine run(goal());
  run.begin().settle(0).leave(0, 0.7);
  EXPECT_EQ(run.state(), State::waiting_for_still);
  EXPECT_TRUE(run.progress().left_early);
  EXPECT_EQ(run.progress().stops, 0);
  EXPECT_EQ(run.progress().short_stops, 1);
  // A bump in the second stop, too; it goes on as a new one.
  run.settle(1).fill();
  run.leave(1, 1.2);
  EXPECT_FALSE(run.progress().left_early);
  run.settle(2).leave(2, 0.4).settle(3);
  EXPECT_EQ(run.state(), State::capturing);
  EXPECT_THAT(run.fill(), ElementsAre(Action::secure, Action::end));
  EXPECT_EQ(run.progress().short_stops, 2);
}

TEST(CaptureMachine, AStopWhoseLengthIsKnownAtItsEndCounts) {
  Machine run(goal());
  run.begin().settle(0);
  EXPECT_THAT(run.tell(StopOver{0, 1.1}), ElementsAre(Action::secure));
  EXPECT_THAT(run.tell(StopOver{0, 1.1}), IsEmpty());  // Not twice.
  run.tell(RestOver{});
  EXPECT_EQ(run.state(), State::moving);
  EXPECT_EQ(run.progress().stops, 1);
}

TEST(CaptureMachine, ACameraIsWaitedForButNotForEver) {
  Machine run(goal());
  run.begin().settle(0);
  EXPECT_THAT(run.tell(Rested{3.9}), IsEmpty());
  EXPECT_FALSE(run.progress().is_full);
  EXPECT_THAT(run.tell(Rested{4.0}), ElementsAre(Action::secure));
  run.leave(0, 4.5).settle(1);
  EXPECT_THAT(run.tell(Rested{1.5}), IsEmpty());
  EXPECT_THAT(run.tell(SensorWent{camera}), ElementsAre(Action::secure, Action::end));  // Unplugged.
}

TEST(CaptureMachine, AnImageOfTheStopBeforeDoesNotCount) {
  Machine run(goal());
  run.begin().settle(0).fill();
  run.leave(0, 1.5).settle(1);
  EXPECT_THAT(run.progress().awaited, ElementsAre("camera"));
  EXPECT_THAT(run.tell(Rested{1.0}), IsEmpty());
  EXPECT_THAT(run.tell(ImageCame{camera}), ElementsAre(Action::secure, Action::end));
}

TEST(CaptureMachine, ALidarMayComeAndGo) {
  Machine run(goal());
  run.begin().settle(0);
  run.tell(SensorWent{lidar});
  EXPECT_EQ(run.state(), State::capturing);
  EXPECT_THAT(run.progress().absent, ElementsAre("lidar"));
  EXPECT_THAT(run.fill(), ElementsAre(Action::secure));
  run.tell(SensorCame{lidar});
  EXPECT_THAT(run.progress().absent, IsEmpty());
}

TEST(CaptureMachine, ATableIsToldToTurnAndItsRestsCountOnceItHasArrived) {
  Machine run(goal(true));
  run.begin().settle(0);
  EXPECT_THAT(run.fill(), ElementsAre(Action::secure, Action::turn_table));
  EXPECT_TRUE(run.progress().table_is_turning);
  run.leave(0, 1.4);
  EXPECT_EQ(run.state(), State::moving);
  run.settle(1);
  EXPECT_EQ(run.state(), State::moving);  // It may rest for a moment on its way.
  EXPECT_THAT(run.tell(TableArrived{}), IsEmpty());
  EXPECT_EQ(run.state(), State::capturing);
  EXPECT_THAT(run.fill(), ElementsAre(Action::secure, Action::end));
}

TEST(CaptureMachine, TheStopFromBeforeTheTurnIsNotTakenForTheNextOne) {
  Machine run(goal(true));
  run.begin().settle(0).fill();
  run.tell(TableArrived{});  // Before the stop finder, a second behind, has seen it leave.
  EXPECT_EQ(run.state(), State::moving);
  EXPECT_THAT(run.tell(Rested{2.0}), IsEmpty());
  run.leave(0, 2.0).settle(1);
  EXPECT_EQ(run.state(), State::capturing);
  EXPECT_EQ(run.progress().stops, 1);
}

TEST(CaptureMachine, OfAStopThatAGapPartsOnePartCounts) {
  CaptureGoal three = goal(true);
  three.stops = 3;
  Machine run(three);
  run.begin().settle(0);
  // The stop finder is behind: it tells of the first part at its end, and of the second while the table turns.
  EXPECT_THAT(run.tell(StopOver{0, 2.0}, 5.0), ElementsAre(Action::secure, Action::turn_table));
  run.tell(RestOver{});
  run.tell(RestBegan{});
  run.tell(RestSettled{1, 103.0});
  run.tell(TableArrived{}, 2.0);
  EXPECT_EQ(run.state(), State::moving);
  EXPECT_THAT(run.tell(Rested{4.0}), IsEmpty());
  run.leave(1, 0.5);
  EXPECT_EQ(run.progress().stops, 1);
  EXPECT_EQ(run.progress().short_stops, 0);
  run.settle(2);
  EXPECT_THAT(run.fill(), ElementsAre(Action::secure, Action::turn_table));
  EXPECT_EQ(run.progress().stops, 2);
  // Told of after the table has arrived, it does not count either.
  run.tell(TableArrived{}, 2.0);
  run.leave(2, 1.5);
  run.tell(RestBegan{});
  run.tell(RestSettled{3, 106.0});
  EXPECT_THAT(run.fill(), IsEmpty());
  run.leave(3, 1.5).settle(4);
  EXPECT_THAT(run.fill(), ElementsAre(Action::secure, Action::end));
}

TEST(CaptureMachine, StopsOfATableThatAreFoundAnewDoNotTurnItAgain) {
  CaptureGoal three = goal(true);
  three.stops = 3;
  Machine run(three);
  run.begin().settle(0);
  run.tell(TimePassed{}, 1.5);
  EXPECT_THAT(run.fill(), ElementsAre(Action::secure, Action::turn_table));
  run.tell(TableArrived{}, 2.0);
  run.leave(0, 1.5).settle(1);
  run.tell(FoundAnew{}, 1.0);
  EXPECT_EQ(run.progress().stops, 0);
  run.tell(RestBegan{});
  run.tell(RestSettled{0, 100.0});
  EXPECT_THAT(run.tell(StopOver{0, 1.5}), ElementsAre(Action::secure));
  run.tell(RestOver{});
  run.tell(RestBegan{});
  run.tell(RestSettled{1, 103.5});
  EXPECT_THAT(run.fill(), ElementsAre(Action::secure, Action::turn_table));
  EXPECT_EQ(run.progress().stops, 2);
  // Once more, while it turns.
  run.tell(FoundAnew{}, 1.0);
  for (const double at_s : {100.0, 103.5}) {
    run.tell(RestBegan{});
    run.tell(RestSettled{0, at_s});
    EXPECT_THAT(run.tell(StopOver{0, 1.5}), ElementsAre(Action::secure));
    run.tell(RestOver{});
  }
  run.settle(2);
  EXPECT_EQ(run.state(), State::moving);
  run.tell(TableArrived{}, 1.0);
  EXPECT_THAT(run.fill(), ElementsAre(Action::secure, Action::end));
}

TEST(CaptureMachine, AStuckTableIsToldOnceMoreAndThenItFails) {
  Machine run(goal(true));
  run.begin().settle(0).fill();
  EXPECT_THAT(run.tell(TimePassed{}, 19.9), IsEmpty());
  EXPECT_THAT(run.tell(TimePassed{}, 0.1), ElementsAre(Action::turn_table));
  EXPECT_EQ(run.state(), State::capturing);
  EXPECT_THAT(run.tell(TimePassed{}, 20.0), ElementsAre(Action::end));
  EXPECT_EQ(run.state(), State::failed);
  EXPECT_THAT(run.progress().failure, HasSubstr("the table has not arrived within 20 s"));
  EXPECT_EQ(run.progress().stops, 1);
}

TEST(CaptureMachine, ATableThatSaysItTurnedButDidNotIsFoundOut) {
  Machine run(goal(true));
  run.begin().settle(0).fill();
  run.tell(TableArrived{}, 1.0);
  EXPECT_THAT(run.tell(TimePassed{}, 20.0), ElementsAre(Action::turn_table));
  run.tell(TableArrived{}, 1.0);
  EXPECT_THAT(run.tell(TimePassed{}, 20.0), ElementsAre(Action::end));
  EXPECT_THAT(run.progress().failure, HasSubstr("no rest elsewhere"));
}

TEST(CaptureMachine, ATableThatFailsTellsWhy) {
  Machine run(goal(true));
  run.begin().settle(0).fill();
  EXPECT_THAT(run.tell(TableFailed{"alarm 1"}), ElementsAre(Action::turn_table));
  EXPECT_THAT(run.tell(TableFailed{"alarm 1"}), ElementsAre(Action::end));
  EXPECT_EQ(run.progress().failure, "alarm 1");
  // One that was not asked for anything does not matter.
  Machine idle(goal(true));
  idle.begin();
  EXPECT_THAT(idle.tell(TableFailed{"alarm 1"}), IsEmpty());
  EXPECT_EQ(idle.state(), State::waiting_for_still);
  EXPECT_THAT(idle.tell(TableArrived{}), IsEmpty());
}

TEST(CaptureMachine, StopsThatAreFoundAnewCountAnew) {
  Machine run(goal());
  run.begin().settle(0).fill();
  run.tell(FoundAnew{});
  EXPECT_EQ(run.state(), State::waiting_for_still);
  EXPECT_EQ(run.progress().stops, 0);
  run.settle(0);
  EXPECT_THAT(run.tell(StopOver{0, 2.0}), ElementsAre(Action::secure));
  run.tell(RestOver{});
  run.settle(1);
  EXPECT_THAT(run.fill(), ElementsAre(Action::secure, Action::end));
}

TEST(CaptureMachine, WithoutAGoalItGoesOnUntilItIsTold) {
  CaptureGoal open = goal();
  open.stops = 0;
  Machine run(open);
  run.begin();
  for (int stop = 0; stop < 5; ++stop) {
    run.settle(stop);
    EXPECT_THAT(run.fill(), ElementsAre(Action::secure));
    run.leave(stop, 1.5);
  }
  EXPECT_THAT(run.tell(EndAsked{}), ElementsAre(Action::end));
  EXPECT_EQ(run.state(), State::ended);
  EXPECT_EQ(run.progress().stops, 5);
}

/// Ways into each state.
struct Way {
  State state;
  std::function<void(Machine&)> go;
};

std::vector<Way> ways() {
  return {{State::idle, [](Machine&) {}},
          {State::checking, [](Machine& run) { run.tell(Begun{}); }},
          {State::waiting_for_still, [](Machine& run) { run.begin(); }},
          {State::settling, [](Machine& run) { run.begin().tell(RestBegan{}); }},
          {State::capturing, [](Machine& run) { run.begin().settle(0); }},
          {State::moving,
           [](Machine& run) {
             run.begin().settle(0).fill();
             run.leave(0, 1.5);
           }},
          {State::ended, [](Machine& run) { run.begin().tell(EndAsked{}); }},
          {State::failed, [](Machine& run) { run.begin().tell(RecordingFailed{"full"}); }}};
}

/// What each event makes of each state, where sensors are as the way left them.
TEST(CaptureMachine, EveryEventInEveryState) {
  const State idle = State::idle, checking = State::checking, waiting = State::waiting_for_still,
              settling = State::settling, capturing = State::capturing, moving = State::moving, ended = State::ended,
              failed = State::failed;
  struct Row {
    const char* name;
    CaptureInput input;
    std::vector<State> then;  ///< By state, in the order of `ways`.
  };
  const std::vector<Row> rows{
      {"begun", Begun{}, {checking, checking, waiting, settling, capturing, moving, ended, failed}},
      {"came", SensorCame{camera}, {idle, checking, waiting, settling, capturing, moving, ended, failed}},
      {"went", SensorWent{lidar}, {idle, checking, waiting, settling, capturing, moving, ended, failed}},
      {"nobody", SensorCame{7}, {idle, checking, waiting, settling, capturing, moving, ended, failed}},
      {"image", ImageCame{camera}, {idle, checking, waiting, settling, capturing, moving, ended, failed}},
      {"rest", RestBegan{}, {idle, checking, settling, settling, settling, settling, ended, failed}},
      {"settled", RestSettled{9}, {idle, checking, capturing, capturing, capturing, capturing, ended, failed}},
      {"rested", Rested{0.5}, {idle, checking, waiting, settling, capturing, moving, ended, failed}},
      {"stop over", StopOver{0, 0.2}, {idle, checking, waiting, settling, capturing, moving, ended, failed}},
      {"rest over", RestOver{}, {idle, checking, waiting, waiting, waiting, moving, ended, failed}},
      {"anew", FoundAnew{}, {idle, checking, waiting, waiting, waiting, waiting, ended, failed}},
      {"arrived", TableArrived{}, {idle, checking, waiting, settling, capturing, moving, ended, failed}},
      {"table", TableFailed{"x"}, {idle, checking, waiting, settling, capturing, moving, ended, failed}},
      {"time", TimePassed{}, {idle, checking, waiting, settling, capturing, moving, ended, failed}},
      {"end", EndAsked{}, {ended, ended, ended, ended, ended, ended, ended, failed}},
      {"fault", RecordingFailed{"full"}, {failed, failed, failed, failed, failed, failed, ended, failed}}};
  for (const Row& row : rows) {
    std::size_t i = 0;
    for (const Way& way : ways()) {
      Machine run(goal());
      way.go(run);
      ASSERT_EQ(run.state(), way.state) << row.name;
      const Actions actions = run.tell(row.input);
      EXPECT_EQ(run.state(), row.then[i]) << row.name << " while " << to_string(way.state);
      const bool has_ended = run.state() != way.state && (run.state() == ended || run.state() == failed);
      EXPECT_EQ(actions, has_ended ? Actions{Action::end} : Actions{}) << row.name << " while " << to_string(way.state);
      ++i;
    }
  }
}

TEST(CaptureMachine, AClockThatGoesBackHoldsNothingUp) {
  Machine run(goal());
  run.tell(Begun{});
  run.tell(TimePassed{}, -50.0);
  EXPECT_EQ(run.state(), State::checking);
  run.tell(TimePassed{}, 60.0);
  EXPECT_EQ(run.state(), State::waiting_for_still);
}

}  // namespace
}  // namespace rigcal
