#include "vda5050/reports/live_state.h"

#include <gmock/gmock.h>

namespace fleetpub::vda5050 {
namespace {

using ::testing::IsNull;
using ::testing::SizeIs;

RobotState Talkative(std::size_t length) {
  RobotState state;
  state.errors = {
      {.type = "stuck", .level = "FATAL", .description = std::string(length, 'x'), .hint = "push"},
      {.type = "dull", .level = "WARNING"}};
  state.action_states = {{.id = "a"}};
  return state;
}

// What 20,000 robots with long errors take.
TEST(StateMemory, KeepsNoMoreThanItCan) {
  constexpr std::size_t kLength = 50'000;
  StateMemory memory;
  std::vector<std::shared_ptr<const LiveState>> slots(600);
  for (auto& slot : slots) memory.Keep(slot, Talkative(kLength));
  std::size_t kept = 0;
  for (const auto& slot : slots) kept += slot->errors[0].description.size();
  EXPECT_LT(kept, 21U << 20);
  EXPECT_GT(kept, 15U << 20);
  EXPECT_GT(memory.abridged(), 100U);
  memory.Keep(slots.back(), Talkative(kLength));
  EXPECT_THAT(slots.back()->errors, SizeIs(1));
  EXPECT_EQ(slots.back()->errors[0].level, "FATAL");
  EXPECT_EQ(slots.back()->errors_left_out, 1U);
  // What is no longer said makes room.
  for (auto& slot : slots) memory.Keep(slot, {});
  EXPECT_EQ(memory.abridged(), 0U);
  memory.Keep(slots[1], Talkative(kLength));
  EXPECT_THAT(slots[1]->errors, SizeIs(2));
  EXPECT_FALSE(slots[1]->is_slim);
}

TEST(StateMemory, KeepsWhatATableShowsBeforeItKeepsAllOfAFew) {
  StateMemory memory;
  std::shared_ptr<const LiveState> first;
  std::shared_ptr<const LiveState> second;
  memory.Keep(first, Talkative(std::size_t{8} << 20));
  EXPECT_EQ(first->errors[0].hint, "push");
  EXPECT_THAT(first->action_states, SizeIs(1));
  memory.Keep(second, Talkative(std::size_t{4} << 20));
  EXPECT_TRUE(second->is_slim);
  EXPECT_THAT(second->action_states, SizeIs(0));
  EXPECT_EQ(second->errors[0].description.size(), std::size_t{4} << 20);
  EXPECT_EQ(memory.abridged(), 0U);
}

TEST(WorstError, IsTheOneWhoseLevelWeighsMost) {
  EXPECT_THAT(WorstError({}), IsNull());
  const std::vector<RobotError> errors = {{.type = "a", .level = "ODD"},
                                          {.type = "b", .level = "URGENT"},
                                          {.type = "c", .level = "CRITICAL"},
                                          {.type = "d", .level = "WARNING"}};
  EXPECT_EQ(WorstError(errors)->type, "c");
}

}  // namespace
}  // namespace fleetpub::vda5050
