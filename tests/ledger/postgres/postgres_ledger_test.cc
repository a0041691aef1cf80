// What is particular to the ledger in PostgreSQL: locks that end with a connection, servers that
// end, logins, TLS, rights.
#include "ledger/postgres/postgres_ledger.h"

#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <signal.h>
#include <sys/socket.h>

#include <atomic>
#include <fstream>
#include <sstream>
#include <thread>

#include "ledger/contract.h"
#include "mqtt/certificates.h"
#include "support/free_port.h"
#include "support/pgbouncer.h"

namespace fleetpub::ledger {
namespace {

using std::chrono::seconds;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

std::string FindError(const PostgresOptions& options, OpenMode mode = OpenMode::kCreate) {
  const auto ledger = OpenPostgres(options, mode);
  if (ledger) return "";
  EXPECT_EQ(ledger.error().kind, ErrorKind::kLedger);
  EXPECT_EQ(ledger.error().message.find('\n'), std::string::npos);
  return ledger.error().message;
}

class PostgresLedger : public ::testing::Test {
 protected:
  [[nodiscard]] std::unique_ptr<Ledger> Open(const std::string& user = "operator") const {
    Options who = OptionsFor("");
    who.user = user;
    return Place{Kind::kPostgres, url_}.MustOpen(OpenMode::kCreate, who);
  }
  [[nodiscard]] static Result<std::unique_ptr<TopicLock>> Lock(
      Ledger& ledger, const std::vector<std::string>& topics,
      milliseconds wait = milliseconds(200)) {
    return ledger.Lock(topics, In(wait));
  }
  /// A process that holds the topic until it is killed. Returns when it does.
  [[nodiscard]] pid_t FindHolder(const std::string& topic) const {
    const pid_t holder = StartProcess([&] {
      const auto ledger = Open();
      const auto lock = Lock(*ledger, {topic}, seconds(5));
      pause();
    });
    const auto other = Open();
    while (Lock(*other, {topic}, milliseconds(1))) std::this_thread::yield();
    return holder;
  }

  std::string url_ = Server().MakeDatabase();
};

TEST_F(PostgresLedger, LocksTopicsForOneSession) {
  const auto one = Open("alice");
  const auto two = Open("bob");
  auto lock = Lock(*one, {"a", "b"});
  ASSERT_TRUE(lock) << lock.error().message;
  EXPECT_TRUE((*lock)->StillHeld());
  EXPECT_TRUE(Lock(*two, {"c", "d", "c"}));
  const auto refused = Lock(*two, {"c", "b"});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().kind, ErrorKind::kLedger);
  EXPECT_THAT(refused.error().message,
              AllOf(HasSubstr("alice@control-room"), HasSubstr("topic b for")));
  const auto three = Open();
  EXPECT_TRUE(Lock(*three, {"c"}));  // all or none
  lock->reset();
  EXPECT_TRUE(Lock(*two, {"a", "b"}, seconds(5)));
}

TEST_F(PostgresLedger, WaitsForAllLocksTogetherUntilTheDeadline) {
  const auto one = Open();
  const auto two = Open();
  const auto held = Lock(*one, {"a"});
  std::vector<std::string> topics = {"a", "b", "c", "d"};
  const auto start = steady_clock::now();
  EXPECT_FALSE(Lock(*two, topics, milliseconds(300)));
  EXPECT_GE(steady_clock::now() - start, milliseconds(300));
  EXPECT_TRUE(
      two->Lock(std::span(&topics[1], 1), In(milliseconds(-10))));  // tried once all the same
}

TEST_F(PostgresLedger, GivesAKilledHoldersTopicsToOthers) {
  const pid_t holder = FindHolder("a");
  const auto other = Open();
  EXPECT_FALSE(Lock(*other, {"a"}, milliseconds(20)));
  kill(holder, SIGKILL);
  EXPECT_TRUE(Lock(*other, {"a"}, seconds(5)));
  WaitFor(holder);
}

TEST_F(PostgresLedger, IsNotHeldByAStalledHolderForOtherTopics) {
  const pid_t holder = StartProcess([&] {
    const auto ledger = Open();
    std::vector<std::string> topics;
    std::vector<Draft> drafts;
    for (int robot = 0; robot < 500; ++robot) {
      topics.push_back(MakeTopic(robot));
      drafts.push_back(DraftFor(robot));
    }
    const auto lock = ledger->Lock(topics, In(seconds(5)));
    if (!ledger->Reserve(drafts)) throw std::runtime_error("Reserve");
    raise(SIGSTOP);
  });
  int status = 0;
  waitpid(holder, &status, WUNTRACED);
  ASSERT_TRUE(WIFSTOPPED(status));
  const auto own = Open();
  auto lock = Lock(*own, {MakeTopic(1'000)});
  ASSERT_TRUE(lock) << lock.error().message;
  EXPECT_EQ(MustReserve(*own, DraftFor(1'000)).header_id, 0U);
  lock->reset();
  EXPECT_FALSE(Lock(*own, {MakeTopic(499)}, milliseconds(50)));
  kill(holder, SIGKILL);
  WaitFor(holder);
  ASSERT_TRUE(Lock(*own, {MakeTopic(499)}, seconds(5)));
  EXPECT_EQ(own->PeekNext(MakeTopic(499)), 1U);
}

TEST_F(PostgresLedger, NeverWaitsInACircle) {
  std::vector<std::string> topics;
  for (char letter = 'a'; letter <= 'z'; ++letter) topics.emplace_back(1, letter);
  const std::vector<std::string> reversed(topics.rbegin(), topics.rend());
  std::atomic<int> failures = 0;
  const auto take = [&](const std::vector<std::string>& all) {
    const auto ledger = Open();
    for (int round = 0; round < 100 && failures == 0; ++round) {
      failures += Lock(*ledger, all, seconds(5)) ? 0 : 1;
    }
  };
  std::thread forwards([&] { take(topics); });
  std::thread backwards([&] { take(reversed); });
  forwards.join();
  backwards.join();
  EXPECT_EQ(failures, 0);
}

TEST_F(PostgresLedger, GivesNoIdTwiceEvenToWhoDoesNotLock) {
  const auto one = Open();
  const auto two = Open();
  const auto lock = Lock(*one, {MakeTopic(1)});  // reads the last id: none
  ASSERT_TRUE(lock);
  EXPECT_EQ(MustReserve(*two).header_id, 0U);
  EXPECT_EQ(MustReserve(*two).header_id, 1U);
  EXPECT_EQ(MustReserve(*one).header_id, 2U);
  EXPECT_EQ(one->History({})->size(), 3U);
}

TEST_F(PostgresLedger, OfANewerVersionIsRefused) {
  MustReserve(*Open());
  Server().Sql(url_, "UPDATE fleetpub.ledger_version SET version = 2");
  const auto options = PostgresOptionsFor(url_, OptionsFor(""));
  EXPECT_THAT(FindError(options), AllOf(HasSubstr("newer fleetpub"), HasSubstr(url_)));
  EXPECT_THAT(FindError(options, OpenMode::kReadOnly), HasSubstr("newer fleetpub"));
}

TEST_F(PostgresLedger, SendsOnlyWhatIsOnTheServersDisk) {
  MustReserve(*Open());
  Server().Sql(url_,
               "DO $$BEGIN EXECUTE format('ALTER DATABASE %I SET synchronous_commit = off', "
               "current_database()); END$$");
  Server().Sql(url_,
               "CREATE FUNCTION look() RETURNS trigger LANGUAGE plpgsql AS $$BEGIN "
               "NEW.profile = current_setting('synchronous_commit'); RETURN NEW; END$$; "
               "CREATE TRIGGER look BEFORE INSERT OR UPDATE ON fleetpub.messages FOR EACH ROW "
               "EXECUTE FUNCTION look()");
  const auto ledger = Open();
  const std::int64_t row = MustReserve(*ledger).row;
  EXPECT_EQ(ledger->Find(row)->value().profile, "on");
  MustRecord(*ledger, {row, "SENT", ""});
  EXPECT_EQ(ledger->Find(row)->value().profile, "off");
  EXPECT_EQ(ledger->Find(MustReserve(*ledger).row)->value().profile, "on");
}

TEST_F(PostgresLedger, TellsWhatRightsAreMissing) {
  const std::string name = url_.substr(url_.rfind('/') + 1);
  Server().Sql(url_, "CREATE ROLE " + name + "_op LOGIN");
  const auto options = PostgresOptionsFor(Server().Url(name, name + "_op"), OptionsFor(""));
  EXPECT_THAT(FindError(options), AllOf(HasSubstr("ledger migrate"), HasSubstr("grant")));
  MustReserve(*Open());  // the owner makes the tables
  EXPECT_THAT(FindError(options), HasSubstr("grant"));
  Server().Sql(url_, "GRANT USAGE ON SCHEMA fleetpub TO " + name +
                         "_op; GRANT SELECT, INSERT, UPDATE ON ALL TABLES IN SCHEMA fleetpub TO " +
                         name + "_op");
  const auto ledger = OpenPostgres(options, OpenMode::kCreate);
  ASSERT_TRUE(ledger) << ledger.error().message;
  EXPECT_EQ(MustReserve(**ledger).header_id, 1U);
  MustRecord(**ledger, {2, "SENT", ""});
}

TEST_F(PostgresLedger, ThatIsAStandbyIsRefused) {
  MustReserve(*Open());
  Server().Sql(url_,
               "DO $$BEGIN EXECUTE format('ALTER DATABASE %I SET "
               "default_transaction_read_only = on', current_database()); END$$");
  const auto options = PostgresOptionsFor(url_, OptionsFor(""));
  EXPECT_THAT(FindError(options), HasSubstr("read-only"));
  EXPECT_EQ(FindError(options, OpenMode::kReadOnly), "");
}

TEST_F(PostgresLedger, ThatDoesNotAnswerIsGivenUp) {
  PostgresOptions options = PostgresOptionsFor(url_, OptionsFor(""));
  options.patience = milliseconds(300);
  const auto ledger = OpenPostgres(options, OpenMode::kCreate);
  ASSERT_TRUE(ledger);
  MustReserve(**ledger);
  const std::string backend =
      Server().Sql(url_,
                   "SELECT pid FROM pg_stat_activity WHERE application_name LIKE 'fleetpub%' "
                   "AND datname = current_database()");
  const pid_t pid = std::stoi(backend);
  kill(pid, SIGSTOP);
  const Draft draft = DraftFor();
  const auto refused = (*ledger)->Reserve(std::span(&draft, 1));
  kill(pid, SIGCONT);
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().message, HasSubstr("did not answer for"));
}

TEST(PostgresThatIsNotThere, IsRefused) {
  const std::string url =
      "postgresql://127.0.0.1:" + std::to_string(testing::FreePort()) + "/fleet";
  EXPECT_THAT(FindError(PostgresOptionsFor(url, OptionsFor(""))),
              AllOf(HasSubstr("cannot reach the ledger " + url), HasSubstr("refused")));
}

TEST(PostgresThatIsNotThere, IsNotWaitedForLonger) {
  // Listens, and says nothing.
  const int listener = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof address;
  ASSERT_EQ(bind(listener, reinterpret_cast<sockaddr*>(&address), size), 0);
  ASSERT_EQ(listen(listener, 1), 0);
  ASSERT_EQ(getsockname(listener, reinterpret_cast<sockaddr*>(&address), &size), 0);
  PostgresOptions options = PostgresOptionsFor(
      "postgresql://127.0.0.1:" + std::to_string(ntohs(address.sin_port)) + "/fleet",
      OptionsFor(""));
  options.connect_timeout = milliseconds(100);  // libpq makes two seconds of it
  EXPECT_THAT(FindError(options), HasSubstr("no answer in time"));
  close(listener);
}

/// A server that a test may end, and may ask for passwords.
class OwnPostgresServer : public ::testing::Test {
 protected:
  [[nodiscard]] std::unique_ptr<Ledger> Open() const {
    return Place{Kind::kPostgres, server_.Url()}.MustOpen();
  }
  testing::Postgres server_;
};

TEST_F(OwnPostgresServer, IsReachedAgainAfterARestart) {
  const auto ledger = Open();
  const Reservation sent = MustReserve(*ledger);
  server_.Stop();
  std::thread recording([&] { MustRecord(*ledger, {sent.row, "FINISHED", ""}); });  // waits
  std::this_thread::sleep_for(milliseconds(200));
  server_.Start();
  recording.join();
  EXPECT_EQ(ledger->Find(sent.row)->value().status, "FINISHED");
  server_.Restart();
  const std::vector<std::string> topics = {MakeTopic(1)};
  EXPECT_TRUE(ledger->Lock(topics, In(seconds(5))));
  EXPECT_EQ(MustReserve(*ledger).header_id, 1U);
}

TEST_F(OwnPostgresServer, TakesLocksWithItAndReservesNothingWithoutThem) {
  const auto ledger = Open();
  const std::vector<std::string> topics = {MakeTopic(1)};
  {
    const auto lock = ledger->Lock(topics, In(seconds(5)));
    ASSERT_TRUE(lock);
    MustReserve(*ledger);
    EXPECT_TRUE((*lock)->StillHeld());
    server_.Restart();
    EXPECT_FALSE((*lock)->StillHeld());
    const Draft draft = DraftFor();
    EXPECT_FALSE(ledger->Reserve(std::span(&draft, 1)));
  }
  const auto again = ledger->Lock(topics, In(seconds(5)));
  ASSERT_TRUE(again) << again.error().message;
  EXPECT_EQ(MustReserve(*ledger).header_id, 1U);
  EXPECT_EQ(ledger->History({})->size(), 2U);
}

TEST_F(OwnPostgresServer, IsReachedThroughAPoolOfSessions) {
  const testing::PgBouncer pool(server_, "session");
  const std::vector<std::string> topics = {MakeTopic(1)};
  for (std::uint32_t id = 0; id < 2; ++id) {
    const auto ledger = Place{Kind::kPostgres, pool.Url()}.MustOpen();
    const auto lock = ledger->Lock(topics, In(seconds(5)));
    ASSERT_TRUE(lock) << lock.error().message;
    EXPECT_EQ(MustReserve(*ledger).header_id, id);
  }
}

// Both would get the same server process, which gives its own locks again.
TEST_F(OwnPostgresServer, IsRefusedBehindAPoolThatSharesSessions) {
  const testing::PgBouncer pool(server_, "transaction");
  const std::vector<std::string> topics = {MakeTopic(1)};
  const auto first = Place{Kind::kPostgres, pool.Url()}.MustOpen();
  const auto second = Place{Kind::kPostgres, pool.Url()}.MustOpen();
  auto held = first->Lock(topics, In(seconds(5)));
  ASSERT_TRUE(held) << held.error().message;
  const auto refused = second->Lock(topics, In(seconds(5)));
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().kind, ErrorKind::kLedger);
  EXPECT_THAT(refused.error().message, HasSubstr("use one in session mode"));
  held->reset();
  EXPECT_TRUE(second->Lock(topics, In(seconds(5))));
}

TEST_F(OwnPostgresServer, AsksForAPassword) {
  server_.Sql(server_.Url(), "CREATE ROLE alice LOGIN SUPERUSER PASSWORD 'hush'");
  server_.Authenticate("host all alice 127.0.0.1/32 scram-sha-256\n");
  PostgresOptions options = PostgresOptionsFor(server_.Url("postgres", "alice"), OptionsFor(""));
  EXPECT_THAT(FindError(options), AllOf(HasSubstr("password"), HasSubstr("PGPASSFILE")));
  options.password = "wrong";
  EXPECT_THAT(FindError(options), AllOf(HasSubstr("not accepted"), Not(HasSubstr("wrong"))));
  options.password = "hush";
  EXPECT_EQ(FindError(options), "");
}

TEST_F(OwnPostgresServer, IsVerifiedByItsCertificate) {
  const auto& certificates = mqtt::Certificates::Get();
  const auto content = [&](const std::string& name) {
    std::ostringstream text;
    text << std::ifstream(certificates / name).rdbuf();
    return text.str();
  };
  server_.Configure("ssl = on\nssl_cert_file = 'server.crt'\nssl_key_file = 'server.key'\n",
                    {{"server.crt", content("server.crt")}, {"server.key", content("server.key")}});
  server_.Authenticate("hostnossl all all 127.0.0.1/32 reject\n");
  const auto error_with = [&](const std::string& parameters) {
    return FindError(PostgresOptionsFor(server_.Url() + "?" + parameters, OptionsFor("")));
  };
  EXPECT_EQ(error_with("sslmode=verify-full&sslrootcert=" + (certificates / "ca.crt")), "");
  EXPECT_THAT(error_with("sslmode=verify-full&sslrootcert=" + (certificates / "stranger.crt")),
              HasSubstr("its certificate is not accepted"));
  EXPECT_THAT(error_with("sslmode=disable"), HasSubstr("pg_hba.conf"));
}

}  // namespace
}  // namespace fleetpub::ledger
