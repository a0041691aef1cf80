// One ledger in PostgreSQL for several hosts: the real binary, a real server.
#include "support/postgres.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <filesystem>
#include <map>
#include <random>
#include <set>
#include <thread>

#include "base/json.h"
#include "support/free_port.h"
#include "support/operator.h"

namespace fleetpub::testing {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::SizeIs;

class PostgresLedger : public EndToEnd {
 protected:
  PostgresLedger() { operator_.UseLedger(server_.Url()); }

  Postgres server_;
};

std::vector<std::string> Robots(int count) {
  std::vector<std::string> robots;
  for (int i = 1; i <= count; ++i) robots.push_back(fmt::format("KIT/{:04}", i));
  return robots;
}

std::vector<std::string> With(std::vector<std::string> first, std::vector<std::string> more) {
  first.insert(first.end(), more.begin(), more.end());
  return first;
}

/// On each topic every id lies above the one before.
void ExpectRisingIds(const std::vector<Subscriber::Received>& messages) {
  std::map<std::string, std::int64_t> last;
  for (const auto& message : messages) {
    const std::int64_t id = Json(message.payload)["headerId"].GetInt64();
    const auto [before, first] = last.try_emplace(message.topic, -1);
    ASSERT_GT(id, before->second) << message.topic;
    before->second = id;
  }
}

TEST_F(PostgresLedger, KeepsTheIdsOfTwoHostsApart) {
  const std::vector<std::string> robots = Robots(100);
  const auto running = Robot({"KIT/0001", "--count", "100"});
  const Subscriber subscriber(broker_, "vda5050/v3/KIT/+/instantActions");
  Operator other;  // a home and a state folder of its own
  other.UseBroker(broker_.Url());
  other.UseLedger(server_.Url());
  constexpr int kRounds = 6;
  const auto command = [&](const Operator& host, unsigned seed) {
    std::mt19937 random(seed);
    for (int round = 0; round < kRounds; ++round) {
      const char* action = round % 2 == 0 ? "pause" : "resume";
      if (round == 1 || round == 3) {  // killed at some moment, it must not harm the other's ids
        Process killed(host.Prepare(WithoutLook(With({action}, robots))));
        std::this_thread::sleep_for(std::chrono::milliseconds(10 + random() % 40));
        killed.Signal(SIGKILL);
        EXPECT_TRUE(killed.Wait().has_value());
      }
      // Those that do not wait for the robots meet more often.
      std::vector<std::string> words = {action};
      if (round % 4 == 0) words.emplace_back("--wait");
      const auto ran = host.Send(With(words, robots));
      EXPECT_EQ(ran.exit_code, 0) << ran.errors << ran.output;
    }
  };
  std::vector<std::thread> all;
  for (unsigned seed = 0; seed < 4; ++seed) {
    all.emplace_back([&, seed] { command(seed % 2 == 0 ? operator_ : other, seed); });
  }
  for (std::thread& thread : all) thread.join();
  const std::size_t least = all.size() * kRounds * robots.size();
  const auto messages = subscriber.Await(least);
  EXPECT_GE(messages.size(), least);
  ExpectRisingIds(messages);
  std::set<std::string> recorded;
  for (const std::string& line :
       Lines(other.Fleetpub({"history", "--limit", "0", "-o", "json"}).output)) {
    recorded.insert(base::ToJson(Json(line)["payload"]));
  }
  for (const auto& message : messages) EXPECT_TRUE(recorded.contains(message.payload));
  EXPECT_FALSE(std::filesystem::exists(operator_.LedgerPath()));
}

TEST_F(PostgresLedger, ThatIsDownSendsNothing) {
  operator_.UseLedger("postgresql://127.0.0.1:" + std::to_string(FreePort()) + "/fleet");
  const auto refused = Send({"pause", "KIT/0001", "--connect-timeout", "2s"});
  EXPECT_EQ(refused.exit_code, 8);
  EXPECT_THAT(refused.errors, AllOf(HasSubstr("nothing was sent"), HasSubstr("cannot reach the "
                                                                             "ledger")));
  EXPECT_THAT(broker_.Log(), Not(HasSubstr("New client connected")));
  EXPECT_EQ(Fleetpub({"history"}).exit_code, 8);
  EXPECT_EQ(Fleetpub({"ledger", "status"}).exit_code, 8);
}

TEST_F(PostgresLedger, MayRestartWhileACommandRuns) {
  const auto robot = Robot({"KIT/0001", "--delay", "2s"});
  Process run(operator_.Prepare({"pause", "KIT/0001", "--wait"}));
  while (Fleetpub({"history", "-o", "json"}).output.empty()) {
  }
  server_.Restart();
  EXPECT_EQ(run.Wait(), 0) << run.Errors();
  EXPECT_EQ(run.Errors(), "");
  EXPECT_THAT(Fleetpub({"history", "-o", "json"}).output, HasSubstr(R"("status":"FINISHED")"));
}

TEST_F(PostgresLedger, MayRestartBetweenTheLinesOfABatch) {
  Command command = operator_.Prepare({"batch", "--vda", "3.0", "--no-check", "-o", "json"});
  command.input = std::nullopt;
  Process batch(std::move(command));
  batch.Write("{\"id\":\"one\",\"target\":\"KIT/0001\",\"action\":\"startPause\"}\n");
  ASSERT_TRUE(batch.AwaitOutput("SENT"));
  server_.Restart();
  batch.Write("{\"id\":\"two\",\"target\":\"KIT/0001\",\"action\":\"stopPause\"}\n");
  ASSERT_TRUE(batch.AwaitOutput("stopPause"));
  batch.CloseInput();
  EXPECT_EQ(batch.Wait(), 0) << batch.Errors();
  EXPECT_THAT(batch.Output(), HasSubstr(R"("headerId":1)"));
}

TEST_F(PostgresLedger, IsDescribedAndMade) {
  EXPECT_THAT(Fleetpub({"ledger", "status"}).output, HasSubstr("none yet"));
  EXPECT_THAT(Fleetpub({"ledger", "migrate"}).output, HasSubstr("now has version 1"));
  EXPECT_THAT(Fleetpub({"ledger", "migrate"}).output, HasSubstr("version 1 already"));
  EXPECT_EQ(Send({"pause", "KIT/0001", "KIT/0002"}).exit_code, 0);
  const auto status = Json(Fleetpub({"ledger", "status", "-o", "json"}).output);
  EXPECT_STREQ(status["kind"].GetString(), "PostgreSQL");
  EXPECT_EQ(status["place"].GetString(), server_.Url());
  EXPECT_EQ(status["version"].GetInt(), 1);
  EXPECT_EQ(status["rows"].GetInt(), 2);
  EXPECT_EQ(status["topics"].GetInt(), 2);
}

TEST_F(PostgresLedger, LogsInWithoutAPasswordInSight) {
  server_.Sql(server_.Url(), "CREATE ROLE alice LOGIN SUPERUSER PASSWORD 'hush'");
  server_.Authenticate("host all alice 127.0.0.1/32 scram-sha-256\n");
  operator_.UseLedger(server_.Url("postgres", "alice"));
  EXPECT_EQ(Send({"pause", "KIT/0001"}).exit_code, 8);
  const auto with = [&](const char* variable, const std::string& value) {
    Command command = operator_.Prepare(WithoutLook({"pause", "KIT/0001"}));
    command.environment.emplace_back(variable, value);
    return testing::Run(std::move(command));
  };
  const auto passwords = operator_.home().Write("pgpass", "*:*:*:alice:hush\n");
  const auto credential = operator_.home().Write("credentials/fleetpub.ledger_password", "hush\n");
  for (const auto& file : {passwords, credential}) {
    std::filesystem::permissions(file, std::filesystem::perms::owner_read);
  }
  EXPECT_EQ(with("PGPASSFILE", passwords.string()).exit_code, 0);
  EXPECT_EQ(with("PGPASSWORD", "hush").exit_code, 0);
  EXPECT_EQ(with("CREDENTIALS_DIRECTORY", credential.parent_path().string()).exit_code, 0);
  EXPECT_EQ(with("PGPASSWORD", "wrong").exit_code, 8);
}

class LedgerPlace : public EndToEnd {};

TEST_F(LedgerPlace, WithAPasswordIsRefusedWhereverItStands) {
  const std::string url = "postgresql://op:hush@127.0.0.1/fleet";
  const auto config = operator_.home().Write("config.toml", "ledger = \"" + url + "\"\n");
  Operator with_variable;
  with_variable.UseLedger(url);
  Operator with_file;
  with_file.UseLedger(std::nullopt);
  for (const Finished& refused :
       {Send({"pause", "KIT/0001", "--ledger", url}), with_variable.Send({"pause", "KIT/0001"}),
        with_file.Send({"pause", "KIT/0001", "--config", config.string()})}) {
    EXPECT_EQ(refused.exit_code, 2) << refused.errors;
    EXPECT_THAT(refused.errors, AllOf(HasSubstr("PGPASSFILE"), Not(HasSubstr("hush"))));
  }
  const auto shown = with_variable.Fleetpub({"config", "show"});
  EXPECT_THAT(shown.output, AllOf(HasSubstr("op:********@127.0.0.1"), Not(HasSubstr("hush"))));
}

#ifdef FLEETPUB_WITHOUT_POSTGRES
TEST_F(LedgerPlace, InADatabaseIsRefusedByABuildWithoutIt) {
  const auto refused = Send({"pause", "KIT/0001", "--ledger", "postgresql://db.example/fleet"});
  EXPECT_EQ(refused.exit_code, 8);
  EXPECT_THAT(refused.errors, HasSubstr("FLEETPUB_POSTGRES"));
  EXPECT_THAT(Fleetpub({"--version"}).output, HasSubstr("without PostgreSQL"));
}
#endif

TEST_F(LedgerPlace, MayBeAUrlInTheConfiguration) {
  const auto config = operator_.home().Write(
      "config.toml", "ledger = \"postgresql://op@db.example/fleet?sslmode=verify-full\"\n");
  operator_.UseLedger(std::nullopt);
  EXPECT_THAT(Fleetpub({"config", "show", "--config", config.string()}).output,
              HasSubstr(" postgresql://op@db.example/fleet?sslmode=verify-full "));
}

TEST_F(LedgerPlace, MayBeAFileThatIsDescribedAsWell) {
  EXPECT_THAT(Fleetpub({"ledger", "status"}).output,
              AllOf(HasSubstr("SQLite"), HasSubstr("none yet")));
  EXPECT_FALSE(std::filesystem::exists(operator_.LedgerPath()));
  EXPECT_THAT(Fleetpub({"ledger", "migrate", "-o", "json"}).output,
              AllOf(HasSubstr(R"("from":0)"), HasSubstr(R"("version":1)")));
  EXPECT_EQ(Send({"pause", "KIT/0001"}).exit_code, 0);
  EXPECT_THAT(Fleetpub({"ledger", "status", "-o", "json"}).output,
              AllOf(HasSubstr(R"("rows":1)"), HasSubstr(operator_.LedgerPath().string())));
}

/// The filters of `history`, on both.
class Filters : public EndToEnd, public ::testing::WithParamInterface<bool> {
 protected:
  Filters() {
    if (!GetParam()) return;
    server_ = std::make_unique<Postgres>();
    operator_.UseLedger(server_->Url());
  }
  [[nodiscard]] std::size_t Count(std::vector<std::string> filter) const {
    filter.insert(filter.begin(), {"history", "-o", "json"});
    const auto ran = Fleetpub(std::move(filter));
    EXPECT_EQ(ran.exit_code, 0) << ran.errors;
    return Lines(ran.output).size();
  }
  std::unique_ptr<Postgres> server_;
};

INSTANTIATE_TEST_SUITE_P(On, Filters, ::testing::Bool(),
                         [](const auto& which) { return which.param ? "Postgres" : "Sqlite"; });

TEST_P(Filters, OfTheHistoryChooseRows) {
  ASSERT_EQ(Send({"pause", "KIT/0001", "KIT/0002"}).exit_code, 0);
  ASSERT_EQ(Send({"resume", "KIT/0001", "-q", "1"}).exit_code, 0);
  const std::string user =
      Json(Lines(Fleetpub({"history", "-o", "json"}).output).front())["user"].GetString();
  EXPECT_EQ(Count({}), 3U);
  EXPECT_EQ(Count({"--target", "KIT/0001"}), 2U);
  EXPECT_EQ(Count({"--action", "startPause"}), 2U);
  EXPECT_EQ(Count({"--status", "PUBLISHED"}), 1U);
  EXPECT_EQ(Count({"--user", user}), 3U);
  EXPECT_EQ(Count({"--user", "nobody-else"}), 0U);
  EXPECT_EQ(Count({"--since", "1h"}), 3U);
  EXPECT_EQ(Count({"--until", "1h"}), 0U);
  EXPECT_EQ(Count({"--limit", "1"}), 1U);
  EXPECT_EQ(Count({"--target", "KIT/0001", "--action", "startPause", "--since", "1h"}), 1U);
}

}  // namespace
}  // namespace fleetpub::testing
