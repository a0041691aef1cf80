// Header ids under parallel processes and `kill -9`.
#include <gmock/gmock.h>

#include <map>
#include <random>
#include <set>
#include <thread>

#include "base/json.h"
#include "support/operator.h"
#include "support/relay.h"

namespace fleetpub::testing {
namespace {

using ::testing::SizeIs;

class HeaderIds : public EndToEnd {};

// Runs `work(i)` on this many threads.
void InParallel(int count, const std::function<void(int)>& work) {
  std::vector<std::thread> threads;
  for (int i = 0; i < count; ++i) threads.emplace_back(work, i);
  for (std::thread& thread : threads) thread.join();
}

TEST_F(HeaderIds, ArriveInOrderFromParallelProcessesAtQos1) {
  const Subscriber subscriber(broker_, "#", 1);
  InParallel(10, [&](int) {
    for (int i = 0; i < 10; ++i) {
      EXPECT_EQ(Send({"pause", "KIT/0001", "-q", "1"}).exit_code, 0);
    }
  });
  const auto messages = subscriber.Await(100);
  ASSERT_THAT(messages, SizeIs(100));
  for (int i = 0; i < 100; ++i) {
    EXPECT_EQ(Json(messages[static_cast<std::size_t>(i)].payload)["headerId"].GetInt(), i);
  }
}

// All batches of the distant one are on their way when the near one commands the same robots.
TEST_F(HeaderIds, ArriveInOrderFromWholeFleetsAtADistance) {
  constexpr int kRobots = 1'200;
  const Relay far(broker_.port(), std::chrono::milliseconds(700));
  const Subscriber subscriber(broker_);  // at QoS 1 mosquitto would queue 1,000 and drop the rest
  const auto pausing = [&](const std::string& broker, int step) {
    Command command = operator_.Prepare(WithoutLook({"pause", "-", "-q", "1", "-b", broker}));
    command.input.emplace();
    for (int i = 0; i < kRobots; i += step) *command.input += "KIT/" + std::to_string(i) + "\n";
    return command;
  };
  Process distant(pausing(far.Url(), 1));
  const std::vector<std::string> last = {"history", "-o", "json", "--target", "KIT/1199"};
  while (Fleetpub(last).output.empty()) std::this_thread::yield();
  EXPECT_EQ(testing::Run(pausing(broker_.Url(), 50)).exit_code, 0);
  EXPECT_EQ(distant.Wait(), 0) << distant.Errors();
  const auto messages = subscriber.Await(kRobots + kRobots / 50);
  ASSERT_THAT(messages, SizeIs(kRobots + kRobots / 50));
  std::map<std::string, int> next;
  for (const auto& message : messages) {
    EXPECT_EQ(Json(message.payload)["headerId"].GetInt(), next[message.topic]++) << message.topic;
  }
}

TEST_F(HeaderIds, NeverRepeatOrFallThoughProcessesAreKilledAtRandom) {
  const Subscriber subscriber(broker_, "#", 1);
  InParallel(40, [&](int thread) {
    std::mt19937 random(static_cast<unsigned>(thread));
    for (int i = 0; i < 25; ++i) {
      const std::string robot = "KIT/" + std::to_string(thread % 3);
      Process run(operator_.Prepare(WithoutLook({"pause", robot, "-q", "1"})));
      if (i % 2 == 0) {
        std::this_thread::sleep_for(std::chrono::microseconds(random() % 60'000));
        run.Signal(SIGKILL);
        EXPECT_TRUE(run.Wait().has_value());
      } else {
        EXPECT_EQ(run.Wait(), 0) << run.Errors();
      }
    }
  });
  EXPECT_EQ(Send({"pause", "KIT/last", "-q", "1"}).exit_code, 0);
  const auto last_has_come = [](const auto& messages) {
    return !messages.empty() && messages.back().topic.find("/last/") != std::string::npos;
  };
  auto messages = subscriber.Await(481);
  while (!last_has_come(messages)) messages = subscriber.Await(messages.size() + 1);

  // Nothing arrived that was not recorded, nothing twice; and on each topic the ledger's ids rise
  // row by row.
  std::set<std::string> recorded;
  std::map<std::string, std::int64_t> last;
  for (const std::string& line :
       Lines(Fleetpub({"history", "--limit", "0", "-o", "json"}).output)) {
    const auto row = Json(line);
    const auto id = row["headerId"].GetInt64();
    const auto [entry, first] = last.try_emplace(row["topic"].GetString(), id);
    EXPECT_TRUE(first || id > entry->second) << line;
    entry->second = id;
    recorded.insert(base::ToJson(row["payload"]));
  }
  std::set<std::string> received;
  for (const auto& message : messages) {
    EXPECT_TRUE(recorded.contains(message.payload)) << message.payload;
    EXPECT_TRUE(received.insert(message.payload).second) << "twice: " << message.payload;
  }
  EXPECT_GE(received.size(), 481U) << "twelve of each thread were not killed, and the last one";
}

}  // namespace
}  // namespace fleetpub::testing
