// Brokers that refuse, break or are none: the exit code, a sentence that helps, and what was sent.
#include <gmock/gmock.h>

#include <chrono>

#include "support/free_port.h"
#include "support/operator.h"
#include "support/scripted_broker.h"

namespace fleetpub::testing {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;
using ::testing::AllOf;
using ::testing::AnyOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::SizeIs;

constexpr const char* kShort = "600ms";

class BrokerFailures : public ::testing::Test {
 protected:
  [[nodiscard]] Finished Call(const std::string& url, std::vector<std::string> arguments) const {
    arguments.insert(arguments.end(), {"-b", url});
    return operator_.Fleetpub(std::move(arguments));
  }
  /// Nobody is looked up before.
  [[nodiscard]] Finished Pause(const std::string& url, std::vector<std::string> more = {}) const {
    more.insert(more.begin(), {"pause", "KIT/0001"});
    return Call(url, WithoutLook(std::move(more)));
  }
  /// The audit trail, oldest first.
  [[nodiscard]] std::vector<std::string> History() const {
    return Lines(operator_.Fleetpub({"history", "-o", "json"}).output);
  }

  Operator operator_;
};

// Every command that talks to a broker ends with exit 4, and soon.
TEST_F(BrokerFailures, OfReachingItAreNamedByEveryCommand) {
  const BrokenBroker silent(BrokenBroker::Silent());
  const std::pair<std::string, std::string> peers[] = {
      {"mqtt://127.0.0.1:" + std::to_string(FreePort()), "connection refused: is a broker running"},
      {"mqtt://broker.invalid", "the name"},
      {silent.Url(), "gave no MQTT answer within [0-9]+ ms:"},
  };
  const std::vector<std::vector<std::string>> commands = {
      {"pause", "KIT/0001"},
      {"pause", "KIT/0001", "--wait"},
      {"fleet"},
      {"await", "KIT/0001", "state", "paused=true", "-W", kShort},
      {"ping"}};
  for (const auto& [url, words] : peers) {
    for (auto command : commands) {
      command.insert(command.end(), {"--connect-timeout", kShort});
      const Finished run = Call(url, command);
      EXPECT_EQ(run.exit_code, 4) << command[0] << run.output << run.errors;
      EXPECT_THAT(run.errors, AllOf(::testing::ContainsRegex(words), HasSubstr(url)));
      EXPECT_EQ(run.errors.find("nothing was sent") != std::string::npos, command[0] == "pause");
    }
  }
  EXPECT_THAT(History(), IsEmpty()) << "no header id was used";
}

TEST_F(BrokerFailures, OfWhatIsNoBrokerSayWhatItIs) {
  const std::pair<std::string, std::string> greetings[] = {
      {"SSH-2.0-OpenSSH_9.2\r\n", "not an MQTT broker: check the port"},
      {"HTTP/1.1 400 Bad Request\r\n\r\n", "write ws://"},
      {std::string(64, '\xFF'), "not an MQTT broker: check the port"},
      {std::string("\x20\xFF\xFF\xFF\xFF\xFF", 6), "cannot connect"},
  };
  for (const auto& [bytes, words] : greetings) {
    const BrokenBroker peer(BrokenBroker::Greets(bytes));
    const Finished run = Pause(peer.Url(), {"--connect-timeout", "1s"});
    EXPECT_EQ(run.exit_code, 4) << run.errors;
    EXPECT_THAT(run.errors, AllOf(HasSubstr("nothing was sent"), HasSubstr(words)));
  }
  const BrokenBroker gone(BrokenBroker::ClosesAtOnce());
  EXPECT_THAT(Pause(gone.Url()).errors, HasSubstr("closed the connection without an answer"));
  EXPECT_THAT(History(), IsEmpty());
}

// Garbage where the answers to our packets belong.
TEST_F(BrokerFailures, OfABrokerThatTalksNonsenseAreNoSuccess) {
  for (const std::string& garbage :
       {std::string(64, '\xFF'), std::string("\x40\xFF\xFF\xFF\xFF\xFF", 6),
        std::string("\x40\x00", 2), std::string("\x00\x00\x00\x00", 4)}) {
    const BrokenBroker peer(BrokenBroker::Answers({BrokenBroker::Connack(0), garbage}));
    const Finished run = Pause(peer.Url(), {"-q", "1", "--connect-timeout", kShort});
    EXPECT_EQ(run.exit_code, 4) << run.output;
    EXPECT_THAT(run.output, HasSubstr("sent, but not acknowledged"));
    const Finished waits = Call(
        peer.Url(), {"pause", "KIT/0001", "--wait", "--connect-timeout", kShort, "-W", kShort});
    EXPECT_EQ(waits.exit_code, 4) << waits.output << waits.errors;
    EXPECT_THAT(waits.errors, HasSubstr("nothing was sent"));
  }
}

TEST_F(BrokerFailures, OfRefusalsSayWhatToDo) {
  const std::tuple<int, const char*, const char*> codes[] = {
      {1, "3.1.1", "try the other one with -V"},
      {2, "3.1.1", "choose another one with --client-id"},
      {3, "3.1.1", "try again later"},
      {4, "3.1.1", "bad user name or password: check --username"},
      {5, "3.1.1", "not authorized: check --username"},
      {0x80, "5", "unspecified error"},
      {0x84, "5", "try the other one with -V"},
      {0x85, "5", "choose another one with --client-id"},
      {0x86, "5", "bad user name or password: check --username"},
      {0x87, "5", "not authorized: check --username"},
      {0x88, "5", "try again later"},
      {0x89, "5", "busy: try again later"},
      {0x8A, "5", "banned: ask the broker's administrator"},
      {0x8B, "5", "shutting down: try again later"},
      {0x8C, "5", "name it with --auth-method"},
      {0x97, "5", "quota exceeded"},
      {0x9A, "5", "it takes no retained last will"},
      {0x9B, "5", "it takes no last will at this QoS"},
      {0x9C, "5", "name that one with --broker"},
      {0x9D, "5", "name the new server with --broker"},
      {0x9F, "5", "too many connections"},
  };
  for (const auto& [code, version, words] : codes) {
    const bool v5 = std::string_view(version) == "5";
    const BrokenBroker peer(
        BrokenBroker::Answers({v5 ? BrokenBroker::Connack5(code) : BrokenBroker::Connack(code)}));
    const Finished run = Pause(peer.Url(), {"-V", version});
    EXPECT_EQ(run.exit_code, 4) << code;
    EXPECT_THAT(run.errors, AllOf(HasSubstr("nothing was sent"),
                                  HasSubstr("refused the connection"), HasSubstr(words)));
  }
  EXPECT_THAT(History(), IsEmpty());
}

TEST_F(BrokerFailures, OfAccessListsAreKnownToMqtt5AndWarnedOfBefore) {
  const Mosquitto broker({"allow_anonymous true", "acl_file {}/acl"}, {{"acl", "topic read #\n"}});
  const Subscriber subscriber(broker);
  const Finished known = Pause(broker.Url(), {"-q", "1", "-V", "5"});
  EXPECT_EQ(known.exit_code, 4);
  EXPECT_THAT(known.output, AllOf(HasSubstr("ERROR"), HasSubstr("not authorized (0x87)")));
  const Finished unknown = Pause(broker.Url(), {"-q", "1", "-V", "3.1.1"});
  EXPECT_EQ(unknown.exit_code, 0);
  EXPECT_THAT(unknown.errors,
              AllOf(HasSubstr("access list"), HasSubstr("-V 5"), HasSubstr("--wait")));
  EXPECT_THAT(Pause(broker.Url(), {"-q", "1", "--quiet"}).errors, IsEmpty());
  Command batch =
      operator_.Prepare({"batch", "--vda", "3.0", "-q", "1", "-b", broker.Url(), "--no-check"});
  batch.input = R"({"action":"startPause","target":"KIT/0001"})";
  EXPECT_THAT(testing::Run(batch).errors, HasSubstr("access list"));
  EXPECT_THAT(subscriber.SoFar(), IsEmpty());
  const auto rows = History();
  ASSERT_THAT(rows, SizeIs(4));
  EXPECT_THAT(rows, ::testing::Contains(HasSubstr("not authorized")));
}

TEST_F(BrokerFailures, OfARefusedSubscriptionSendNothing) {
  for (const char* version : {"3.1.1", "5"}) {
    const int code = std::string_view(version) == "5" ? 0x87 : 0x80;
    const ScriptedBroker broker({.suback = code});
    const Finished run = Pause(broker.Url(), {"--wait", "-V", version});
    EXPECT_EQ(run.exit_code, 4) << run.output;
    EXPECT_THAT(run.errors, AllOf(HasSubstr("nothing was sent"),
                                  HasSubstr("refuses the subscription to vda5050/v3/KIT/0001/")));
    EXPECT_EQ(Call(broker.Url(), {"resume", "KIT/0001", "-V", version}).exit_code, 4);
    EXPECT_EQ(
        Call(broker.Url(), {"await", "KIT/0001", "state", "paused=true", "-V", version}).exit_code,
        4);
    EXPECT_EQ(Call(broker.Url(), {"fleet", "-V", version}).exit_code, 4);
    EXPECT_EQ(broker.published(), 0);
    EXPECT_THAT(History(), IsEmpty());
  }
}

// A login that may send and not read can stop a robot.
TEST_F(BrokerFailures, OfARefusedLookHoldBackNoPause) {
  const ScriptedBroker broker({.suback = 0x80});
  const Finished run = Call(broker.Url(), {"pause", "KIT/0001"});
  EXPECT_EQ(run.exit_code, 0) << run.output << run.errors;
  EXPECT_THAT(run.errors, AllOf(HasSubstr("refuses the subscription"), HasSubstr("(assumed)")));
  EXPECT_EQ(broker.published(), 1);
}

TEST_F(BrokerFailures, OfAcknowledgementsThatComeLateAreNoFailures) {
  const ScriptedBroker slow(
      {.before_suback = milliseconds(400), .before_puback = milliseconds(400)});
  const Finished published = Pause(slow.Url(), {"-q", "1", "-V", "5"});
  EXPECT_EQ(published.exit_code, 0) << published.output;
  const Finished unseen = Pause(slow.Url(), {"--wait", "-W", kShort});
  EXPECT_EQ(unseen.exit_code, 6) << unseen.output;
  EXPECT_EQ(slow.published(), 2);
}

// As on a slow line, on which what is retained goes before it.
TEST_F(BrokerFailures, OfSubscriptionsAreNoneWhileSomethingComes) {
  const std::string publish("\x31\x03\x00\x01t", 5);
  const ScriptedBroker slow({.before_suback = milliseconds(2700), .meanwhile = publish});
  const Finished run = Pause(slow.Url(), {"--wait", "-W", kShort, "--connect-timeout", "900ms"});
  EXPECT_EQ(run.exit_code, 6) << run.output << run.errors;
  EXPECT_EQ(slow.published(), 1);
  const Finished endless =
      Pause(ScriptedBroker({.before_suback = milliseconds(1200), .meanwhile = publish}).Url(),
            {"--wait", "--connect-timeout", "100ms"});
  EXPECT_EQ(endless.exit_code, 4) << endless.output;
}

TEST_F(BrokerFailures, OfAcknowledgementsThatComeTooLateSayWhatWasSent) {
  const ScriptedBroker slow({.before_suback = milliseconds(1500), .answers_publish = false});
  const auto start = steady_clock::now();
  const auto Impatient = [&](std::vector<std::string> more) {
    more.insert(more.begin(), {"pause", "KIT/0001", "--connect-timeout", "700ms"});
    return Call(slow.Url(), more);
  };
  for (const Finished& unheard : {Impatient(WithoutLook({"--wait"})), Impatient({})}) {
    EXPECT_EQ(unheard.exit_code, 4) << unheard.output;
    EXPECT_THAT(unheard.errors, HasSubstr("nothing was sent"));
  }
  EXPECT_EQ(slow.published(), 0);
  EXPECT_THAT(History(), IsEmpty());
  const Finished sent = Impatient(WithoutLook({"-q", "1"}));
  EXPECT_EQ(sent.exit_code, 4);
  EXPECT_THAT(sent.output, HasSubstr("may or may not have the message"));
  EXPECT_LT(steady_clock::now() - start, std::chrono::seconds(25)) << "10 s each, untold";
  EXPECT_EQ(slow.published(), 1);
  EXPECT_THAT(History(), ::testing::ElementsAre(HasSubstr(R"("status":"ERROR")")));
}

// Somebody else holds the topic, so that the connection stands and nothing can be sent yet.
TEST_F(BrokerFailures, OfABrokerThatStopsBetweenConnectAndPublishSendNothing) {
  for (const char* qos : {"0", "1"}) {
    const ScriptedBroker deaf({.answers_publish = false});
    Mosquitto broker;
    Process holder(operator_.Prepare(
        WithoutLook({"pause", "KIT/0001", "-q", "1", "-b", deaf.Url(), "--debug"})));
    ASSERT_TRUE(holder.AwaitErrors("-> PUBLISH"));
    Process run(operator_.Prepare(
        WithoutLook({"resume", "KIT/0001", "-q", qos, "-b", broker.Url(), "-v"})));
    ASSERT_TRUE(run.AwaitErrors("connected to"));
    broker.Kill();
    holder.Signal(SIGKILL);
    EXPECT_EQ(run.Wait(), 4) << run.Output();
    EXPECT_THAT(run.Output(), AllOf(HasSubstr("not sent: the connection"), HasSubstr("was lost")));
    EXPECT_THAT(History(), Not(::testing::Contains(HasSubstr("stopPause"))));
  }
}

TEST_F(BrokerFailures, OfABrokerThatHangsUpAfterAMessageSayThatItMayHaveIt) {
  for (const char* version : {"3.1.1", "5"}) {
    constexpr int kPublish = 3;
    const ScriptedBroker broker({.answers_publish = false, .hangs_up_after = kPublish});
    const Finished run = Pause(broker.Url(), {"-q", "1", "-V", version, "KIT/0002"});
    EXPECT_EQ(run.exit_code, 4) << run.output;
    EXPECT_THAT(run.output,
                AnyOf(HasSubstr("sent, but not acknowledged"), HasSubstr("perhaps sent")));
    EXPECT_EQ(broker.connected(), 1) << "no second try";
  }
}

TEST_F(BrokerFailures, OfTooLargeAMessageAreKnownBeforeItIsSent) {
  const Mosquitto broker({"allow_anonymous true", "max_packet_size 2000"});
  const Subscriber subscriber(broker);
  const std::string large = "text=" + std::string(3000, 'x');
  const auto Beep = [&](std::vector<std::string> more) {
    more.insert(more.begin(), {"action", "beep", "KIT/0001", "-q", "1", "-P", large});
    return Call(broker.Url(), WithoutLook(std::move(more)));
  };
  const Finished known = Beep({"-V", "5"});
  EXPECT_EQ(known.exit_code, 4);
  EXPECT_THAT(known.output,
              AllOf(HasSubstr("not sent"), HasSubstr("too large"), HasSubstr("2000 bytes")));
  EXPECT_THAT(History(), IsEmpty()) << "no header id was used";
  const Finished cut = Beep({"-V", "3.1.1"});
  EXPECT_EQ(cut.exit_code, 4) << cut.output;
  EXPECT_THAT(cut.output, HasSubstr("connection"));
  EXPECT_THAT(subscriber.SoFar(), IsEmpty());
}

// One line of a batch does not keep the others from leaving.
TEST_F(BrokerFailures, OfTooLargeAMessageConcernOnlyItsOwnLineOfABatch) {
  const Mosquitto broker({"allow_anonymous true", "max_packet_size 2000"});
  const Subscriber subscriber(broker);
  Command batch = operator_.Prepare(
      {"batch", "--vda", "3.0", "--no-check", "-V", "5", "-q", "1", "-b", broker.Url()});
  batch.input = R"({"action":"startPause","target":"KIT/0001"})"
                "\n"
                R"({"action":"beep","target":"KIT/0002","parameters":{"text":")" +
                std::string(3000, 'x') +
                "\"}}\n"
                R"({"action":"startPause","target":"KIT/0003"})";
  const Finished run = testing::Run(batch);
  EXPECT_EQ(run.exit_code, 4) << run.errors;
  EXPECT_THAT(Lines(run.output),
              ::testing::UnorderedElementsAre(HasSubstr("PUBLISHED"), HasSubstr("too large"),
                                              HasSubstr("PUBLISHED")));
  EXPECT_THAT(subscriber.Await(2), SizeIs(2));
}

}  // namespace
}  // namespace fleetpub::testing
