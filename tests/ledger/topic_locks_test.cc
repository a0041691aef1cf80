#include "ledger/topic_locks.h"

#include <gmock/gmock.h>
#include <signal.h>

#include <atomic>
#include <thread>

#include "ledger/ledger_support.h"

namespace fleetpub::ledger {
namespace {

using std::chrono::seconds;
using ::testing::HasSubstr;

class TopicLocks : public ::testing::Test {
 protected:
  Result<std::unique_ptr<TopicLock>> Lock(const std::vector<std::string>& topics,
                                          milliseconds wait = milliseconds(0)) const {
    return LockTopics(path_, topics, In(wait));
  }

  /// A process that holds the topic until it is killed. Returns when it does.
  [[nodiscard]] pid_t FindHolder(const std::string& topic) const {
    const pid_t holder = StartProcess([&] {
      const auto lock = Lock({topic}, seconds(5));
      pause();
    });
    while (Lock({topic}).has_value()) std::this_thread::yield();
    return holder;
  }

  testing::TemporaryFolder folder_;
  std::filesystem::path path_ = folder_.Write("ledger.db", "");
};

TEST_F(TopicLocks, ExcludeOthersUntilReleased) {
  auto first = Lock({"a"});
  ASSERT_TRUE(first);
  EXPECT_FALSE(Lock({"a"}));
  first->reset();
  EXPECT_TRUE(Lock({"a"}));
}

TEST_F(TopicLocks, OfDifferentTopicsDoNotMeet) {
  const auto first = Lock({"a", "b"});
  ASSERT_TRUE(first);
  EXPECT_TRUE(Lock({"c", "d"}));
}

TEST_F(TopicLocks, AreAllTakenOrNone) {
  const auto held = Lock({"b"});
  EXPECT_FALSE(Lock({"a", "b", "c"}));
  EXPECT_TRUE(Lock({"a", "c"}));
}

TEST_F(TopicLocks, TakeATopicThatIsNamedTwice) { EXPECT_TRUE(Lock({"a", "a"})); }

TEST_F(TopicLocks, WaitUntilTheDeadlineAndNameTheTopic) {
  const auto held = Lock({"KIT/1/instantActions"});
  const auto start = steady_clock::now();
  const auto refused = Lock({"other", "KIT/1/instantActions"}, milliseconds(60));
  EXPECT_GE(steady_clock::now() - start, milliseconds(60));
  EXPECT_LT(steady_clock::now() - start, seconds(20));
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().kind, ErrorKind::kLedger);
  EXPECT_THAT(refused.error().message, HasSubstr("topic KIT/1/instantActions for "));
  EXPECT_THAT(refused.error().message, HasSubstr("fuser"));
}

TEST_F(TopicLocks, AreTakenSoonAfterTheirRelease) {
  auto held = Lock({"a"});
  std::thread releasing([&] {
    std::this_thread::sleep_for(milliseconds(30));
    held->reset();
  });
  EXPECT_TRUE(Lock({"a"}, seconds(5)));
  releasing.join();
}

TEST_F(TopicLocks, AreTriedOnceEvenAfterTheDeadline) {
  EXPECT_TRUE(LockTopics(path_, std::vector<std::string>{"a"}, In(milliseconds(-10))));
}

TEST_F(TopicLocks, ExcludeOtherProcessesUntilTheyAreKilled) {
  const pid_t holder = FindHolder("a");
  EXPECT_FALSE(Lock({"a"}, milliseconds(20)));
  kill(holder, SIGKILL);
  EXPECT_TRUE(Lock({"a"}, seconds(5)));
  WaitFor(holder);
}

TEST_F(TopicLocks, AreNotInheritedByAnotherProgram) {
  auto held = Lock({"a"});
  const pid_t child = StartProcess([] { execlp("sleep", "sleep", "10", nullptr); });
  held->reset();
  EXPECT_TRUE(Lock({"a"}, seconds(5)));
  kill(child, SIGKILL);
  WaitFor(child);
}

TEST_F(TopicLocks, NeverWaitForEachOtherInACircle) {
  std::vector<std::string> topics;
  for (const char letter : std::string("abcdefghijklmnopqrstuvwxyz"))
    topics.emplace_back(1, letter);
  const std::vector<std::string> reversed(topics.rbegin(), topics.rend());
  std::atomic<int> failures = 0;
  const auto take = [&](const std::vector<std::string>& all) {
    const auto end = In(milliseconds(300));
    while (steady_clock::now() < end && failures == 0) failures += Lock(all, seconds(2)) ? 0 : 1;
  };
  std::thread forwards([&] { take(topics); });
  std::thread backwards([&] { take(reversed); });
  forwards.join();
  backwards.join();
  EXPECT_EQ(failures, 0);
}

TEST_F(TopicLocks, OfOneProcessExcludeEachOtherBetweenLedgers) {
  const testing::TemporaryFolder folder;
  const auto one = MustOpen(folder / "l.db");
  const auto two = MustOpen(folder / "l.db");
  const std::vector<std::string> topics = {MakeTopic(1)};
  auto lock = one->Lock(topics, In(seconds(1)));
  ASSERT_TRUE(lock);
  EXPECT_FALSE(two->Lock(topics, In(milliseconds(0))));
  lock->reset();
  EXPECT_TRUE(two->Lock(topics, In(milliseconds(0))));
}

TEST_F(TopicLocks, AreTheSameUnderAnotherNameOfTheLedger) {
  const testing::TemporaryFolder folder;
  const auto one = MustOpen(folder / "l.db");
  std::filesystem::create_symlink(folder / "l.db", folder / "link.db");
  const auto two = MustOpen(folder / "link.db");
  const std::vector<std::string> topics = {MakeTopic(1)};
  const auto lock = one->Lock(topics, In(seconds(1)));
  EXPECT_FALSE(two->Lock(topics, In(milliseconds(0))));
}

TEST_F(TopicLocks, TakeFiveHundredAtOnce) {
  std::vector<std::string> topics;
  topics.reserve(500);
  for (int robot = 0; robot < 500; ++robot) topics.push_back(MakeTopic(robot));
  const auto lock = Lock(topics);
  ASSERT_TRUE(lock);
  EXPECT_FALSE(Lock({MakeTopic(499)}));
}

TEST_F(TopicLocks, SayWhenTheirFileCannotBeMade) {
  std::filesystem::create_directory(path_.string() + ".locks");
  const auto refused = Lock({"a"});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().kind, ErrorKind::kLedger);
  EXPECT_THAT(refused.error().message, HasSubstr("ledger.db.locks"));
}

}  // namespace
}  // namespace fleetpub::ledger
