// The ledger's promise, kept against parallel processes and against SIGKILL.
#include <gmock/gmock.h>
#include <signal.h>

#include <fstream>
#include <map>
#include <random>
#include <set>
#include <thread>

#include "ledger/contract.h"
#include "ledger/sqlite/sqlite_database.h"

namespace fleetpub::ledger {
namespace {

using std::chrono::seconds;

constexpr int kTopics = 3;

/// What left: written by senders while they hold the topic's lock, so that it stands in the order
/// of sending.
struct Sent {
  int robot = 0;
  std::uint32_t header_id = 0;
  std::int64_t row = 0;
};

class ManyProcesses : public Contract {
 protected:
  /// The way of a command, in short.
  void Send(Ledger& ledger, int wire, int robot) const {
    const std::string topic = MakeTopic(robot);
    auto lock = ledger.Lock(std::span(&topic, 1), In(seconds(30)));
    if (!lock) throw std::runtime_error(lock.error().message);
    const Reservation reserved = MustReserve(ledger, DraftFor(robot));
    const std::string line = std::to_string(robot) + " " + std::to_string(reserved.header_id) +
                             " " + std::to_string(reserved.row) + "\n";
    if (write(wire, line.data(), line.size()) < 0) throw std::runtime_error("write");
    lock->reset();
    MustRecord(ledger, {reserved.row, "SENT", ""});
  }

  [[nodiscard]] int OpenWire() const {
    return open((*folder_ / "wire").c_str(), O_WRONLY | O_APPEND | O_CREAT | O_CLOEXEC, 0600);
  }

  [[nodiscard]] std::vector<Sent> ReadWire() const {
    std::vector<Sent> all;
    std::ifstream wire(*folder_ / "wire");
    for (Sent sent; wire >> sent.robot >> sent.header_id >> sent.row;) all.push_back(sent);
    return all;
  }

  /// Waits until one more was sent.
  [[nodiscard]] bool WireGrows() const {
    const std::string wire = *folder_ / "wire";
    const auto before = std::filesystem::file_size(wire);
    for (const auto end = In(seconds(60)); std::filesystem::file_size(wire) == before;) {
      if (steady_clock::now() > end) return false;
      std::this_thread::sleep_for(milliseconds(1));
    }
    return true;
  }

  void ExpectRisingIds(const std::vector<Sent>& all) const {
    std::map<int, std::int64_t> last;
    for (const Sent& sent : all) {
      const auto [before, first] = last.try_emplace(sent.robot, -1);
      ASSERT_GT(std::int64_t{sent.header_id}, before->second) << "robot " << sent.robot;
      before->second = sent.header_id;
    }
  }

  void ExpectRowsFor(const std::vector<Sent>& all) const {
    const auto ledger = place_.MustOpen(OpenMode::kReadOnly);
    const auto records = ledger->History({.limit = 0});
    ASSERT_TRUE(records) << records.error().message;
    std::map<std::int64_t, const Record*> rows;
    for (const Record& record : *records) rows[record.id] = &record;
    for (const Sent& sent : all) {
      ASSERT_TRUE(rows.contains(sent.row));
      ASSERT_EQ(rows[sent.row]->topic, MakeTopic(sent.robot));
      ASSERT_EQ(rows[sent.row]->header_id, sent.header_id);
    }
  }

  void ExpectSoundFile() const {
    if (!IsSqlite()) return;
    auto database = Database::Open(place_.where, Access::kReadWrite, milliseconds(1'000));
    ASSERT_TRUE(database);
    EXPECT_EQ((*database)->Ask("PRAGMA integrity_check"), "ok");
  }

  /// The disk has no part in it, but PostgreSQL takes longer for a database and for a connection.
  [[nodiscard]] static int Rounds(int of_sqlite, int of_postgres = 6) {
    return IsSqlite() ? of_sqlite : of_postgres;
  }
};

FLEETPUB_FOR_EACH_LEDGER(ManyProcesses);

TEST_P(ManyProcesses, GiveEachIdOnceAndInOrder) {
  const int each = Rounds(200, 60);
  std::vector<pid_t> children;
  children.reserve(8);
  for (int child = 0; child < 8; ++child) {
    children.push_back(StartProcess([&] {
      const int wire = OpenWire();
      for (int i = 0; i < each; ++i) {
        // Some keep the ledger open, as a batch does; some open it anew, as one-shot commands do.
        thread_local std::unique_ptr<Ledger> ledger;
        if (!ledger || child % 2 == 0) ledger = place_.MustOpen();
        Send(*ledger, wire, (child + i) % kTopics);
      }
    }));
  }
  for (const pid_t child : children) EXPECT_EQ(WaitFor(child), 0);
  const std::vector<Sent> all = ReadWire();
  ASSERT_EQ(std::ssize(all), 8 * each);
  ExpectRisingIds(all);
  ExpectRowsFor(all);
  std::int64_t total = 0;
  for (int robot = 0; robot < kTopics; ++robot) {
    total += *place_.MustOpen()->PeekNext(MakeTopic(robot));
  }
  EXPECT_EQ(total, 8 * each);  // and none was lost
}

TEST_P(ManyProcesses, KilledAtAnyMomentRepeatNothingAndLoseNothing) {
  const auto start_one = [&](int number) {
    return StartProcess([&] {
      const int wire = OpenWire();
      for (int i = number;; ++i) Send(*place_.MustOpen(), wire, i % kTopics);
    });
  };
  std::mt19937 random(4711);
  std::vector<pid_t> children;
  children.reserve(4);
  close(OpenWire());  // makes it
  for (int child = 0; child < 4; ++child) children.push_back(start_one(child));
  const int all_killed = Rounds(200, 40);
  int killed = 0;
  // One sends before the next is killed: else, where processes start slowly, none might send.
  for (; killed < all_killed && WireGrows(); ++killed) {
    std::this_thread::sleep_for(
        std::chrono::microseconds(random() % (IsSqlite() ? 8'000 : 40'000)));
    pid_t& victim = children[random() % children.size()];
    kill(victim, SIGKILL);
    EXPECT_EQ(WaitFor(victim), SIGKILL);
    victim = start_one(killed);
  }
  for (const pid_t child : children) {
    kill(child, SIGKILL);
    EXPECT_EQ(WaitFor(child), SIGKILL);
  }
  EXPECT_EQ(killed, all_killed);
  const std::vector<Sent> all = ReadWire();
  ExpectRisingIds(all);
  ExpectRowsFor(all);
  ExpectSoundFile();
}

TEST_P(ManyProcesses, KilledWhileMakingTheLedgerLeaveOneThatWorks) {
  std::mt19937 random(11);
  for (int round = 0; round < Rounds(60); ++round) {
    const Place place = NewPlace();
    const pid_t child = StartProcess([&] { MustReserve(*place.MustOpen()); });
    std::this_thread::sleep_for(std::chrono::microseconds(random() % 6'000));
    kill(child, SIGKILL);
    WaitFor(child);
    ASSERT_LE(MustReserve(*place.MustOpen()).header_id, 1U);
  }
}

TEST_P(ManyProcesses, MakeTheLedgerOnceTogether) {
  for (int round = 0; round < Rounds(10); ++round) {
    const Place place = NewPlace();
    std::vector<pid_t> children;
    children.reserve(8);
    for (int child = 0; child < 6; ++child) {
      children.push_back(StartProcess([&] { MustReserve(*place.MustOpen()); }));
    }
    for (const pid_t child : children) ASSERT_EQ(WaitFor(child), 0);
    ASSERT_EQ(place.MustOpen()->PeekNext(MakeTopic(1)), 6U);
  }
}

TEST_P(ManyProcesses, AndThreadsDoNotDisturbEachOther) {
  std::vector<std::thread> threads;
  threads.reserve(4);
  const int wire = OpenWire();
  for (int thread = 0; thread < 4; ++thread) {
    threads.emplace_back([&, thread] {
      for (int i = 0; i < 50; ++i) Send(*place_.MustOpen(), wire, (thread + i) % kTopics);
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(ReadWire().size(), 200U);
  ExpectRisingIds(ReadWire());
}

}  // namespace
}  // namespace fleetpub::ledger
