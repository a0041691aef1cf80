// A ledger that others share and somebody blocks or lays traps at: commands end with a word,
// nothing of the operator's is touched, and a pause has a way.
#include <gmock/gmock.h>
#include <sqlite3.h>
#include <sys/stat.h>

#include <fstream>

#include "support/operator.h"

namespace fleetpub::testing {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::SizeIs;
namespace fs = std::filesystem;

class BlockedLedger : public EndToEnd {
 protected:
  BlockedLedger() {
    fs::create_directory(folder_);
    chmod(folder_.c_str(), 0770);
    operator_.UseLedger(ledger_.string());
    EXPECT_EQ(Send({"pause", "KIT/0001"}).exit_code, 0);
  }

  fs::path folder_ = operator_.home().path() / "shared";
  fs::path ledger_ = folder_ / "ledger.db";
};

TEST_F(BlockedLedger, LeavesAWayForAPauseAndBack) {
  sqlite3* blocker = nullptr;
  ASSERT_EQ(sqlite3_open(ledger_.c_str(), &blocker), SQLITE_OK);
  ASSERT_EQ(sqlite3_exec(blocker, "BEGIN IMMEDIATE", nullptr, nullptr, nullptr), SQLITE_OK);
  const Subscriber subscriber(broker_, "+/+/+/+/instantActions");
  Process blocked(operator_.Prepare(WithoutLook({"startPause", "KIT/0001"})));
  const std::string own = (operator_.home().path() / "pause.db").string();
  const Finished pause =
      Send({"startPause", "KIT/0001", "--ledger", own, "--header-id", "1800000000"});
  EXPECT_EQ(pause.exit_code, 0) << pause.errors;
  ASSERT_THAT(subscriber.Await(1), SizeIs(1));
  EXPECT_EQ(Json(subscriber.SoFar()[0].payload)["headerId"].GetUint(), 1'800'000'000U);
  EXPECT_EQ(blocked.Wait(), 8) << "it waits, and ends";
  EXPECT_THAT(blocked.Output() + blocked.Errors(),
              AllOf(HasSubstr("locked"), HasSubstr("--ledger")));
  sqlite3_close(blocker);
  EXPECT_EQ(Send({"stopPause", "KIT/0001", "--header-id", "1800000001"}).exit_code, 0);
  EXPECT_EQ(Send({"pause", "KIT/0001"}).exit_code, 0);
  const auto messages = subscriber.Await(3);
  ASSERT_THAT(messages, SizeIs(3));
  EXPECT_EQ(Json(messages[2].payload)["headerId"].GetUint(), 1'800'000'002U);
}

TEST_F(BlockedLedger, TrapsBesideItAreToldAndTouchNothing) {
  const fs::path victim = operator_.home().Write("victim", "precious");
  fs::remove(ledger_.string() + "-shm");
  for (const std::string end : {"-journal", "-shm", ".locks"}) {
    const fs::path trap = ledger_.string() + end;
    fs::remove(trap);
    fs::create_symlink(victim, trap);
    const Finished run = Send({"pause", "KIT/0001"});
    EXPECT_EQ(run.exit_code, 8) << end;
    EXPECT_THAT(run.output + run.errors, AllOf(HasSubstr(trap.string()), HasSubstr("remove it")));
    fs::remove(trap);
    ASSERT_EQ(mkfifo(trap.c_str(), 0600), 0);
    EXPECT_EQ(Send({"pause", "KIT/0001"}).exit_code, 8) << end;
    fs::remove(trap);
  }
  EXPECT_EQ(fs::file_size(victim), 8U);
  EXPECT_EQ(Send({"pause", "KIT/0001"}).exit_code, 0);
  const fs::path elsewhere = operator_.home().path() / "elsewhere.db";
  fs::rename(ledger_, elsewhere);
  fs::create_symlink(elsewhere, ledger_);
  for (const char* command : {"pause", "history"}) {
    const bool sends = command == std::string_view("pause");
    const Finished run = sends ? Send({command, "KIT/0001"}) : Fleetpub({command});
    EXPECT_EQ(run.exit_code, 8) << command;
    EXPECT_THAT(run.errors, HasSubstr("not followed"));
  }
}

TEST_F(BlockedLedger, WhatSomebodyPutsIntoItDoesNotRun) {
  const auto plant = [&](const char* sql) {
    sqlite3* other = nullptr;
    ASSERT_EQ(sqlite3_open(ledger_.c_str(), &other), SQLITE_OK);
    EXPECT_EQ(sqlite3_exec(other, sql, nullptr, nullptr, nullptr), SQLITE_OK) << sql;
    sqlite3_close(other);
  };
  plant(
      "CREATE TRIGGER t AFTER INSERT ON messages BEGIN UPDATE header_ids SET last = 0; "
      "DELETE FROM messages; END");
  EXPECT_EQ(Send({"pause", "KIT/0001"}).exit_code, 0);
  EXPECT_THAT(Lines(Fleetpub({"history", "-o", "json"}).output), SizeIs(2));
  plant(
      "DROP TABLE messages; CREATE VIEW messages AS WITH RECURSIVE c(n) AS (VALUES(1) UNION ALL "
      "SELECT n + 1 FROM c) SELECT n AS id FROM c");
  for (const std::vector<std::string>& arguments :
       {WithoutLook({"pause", "KIT/0001"}), {"history"}, {"ledger", "status"}}) {
    const Finished run = Fleetpub(arguments);
    EXPECT_EQ(run.exit_code, 8) << run.errors;
    EXPECT_THAT(run.errors, HasSubstr("not those that fleetpub makes"));
  }
}

}  // namespace
}  // namespace fleetpub::testing
