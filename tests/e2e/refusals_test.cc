// Every way to be refused: the exit code, one sentence, and nothing sent.
#include <gmock/gmock.h>

#include "support/broken_broker.h"
#include "support/free_port.h"
#include "support/operator.h"
#include "support/terminal.h"

namespace fleetpub::testing {
namespace {

using ::testing::AllOf;
using ::testing::AnyOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::SizeIs;
using ::testing::StartsWith;

struct Case {
  std::vector<std::string> arguments;
  int exit_code;
  std::string sentence;  ///< a part of what standard error says
};

class Refusals : public EndToEnd {
 protected:
  // `fleetpub REST`, as a shell reads it.
  [[nodiscard]] Finished InShell(const std::string& rest) const {
    Command command = operator_.Prepare({"actions"});
    command.arguments = {"sh", "-c", Binary() + " " + rest};
    return testing::Run(command);
  }
};

TEST_F(Refusals, SendOnePositionToSeveralOnlyByForce) {
  const Subscriber subscriber(broker_);
  const auto position = [&](std::vector<std::string> words) {
    words.insert(words.end(), {"--x", "1m", "--y", "0", "--theta", "90deg", "--mapId", "hall-1",
                               "--lastNodeId", "n1", "--vda", "3", "--no-check"});
    return Fleetpub(words);
  };
  for (const std::vector<std::string>& words :
       std::vector<std::vector<std::string>>{{"initPosition", "KIT/0001", "KIT/0002"},
                                             {"initializePosition", "KIT/*", "--yes"},
                                             {"initPosition", "--all", "--yes", "--expect", "2"}}) {
    const Finished run = position(words);
    EXPECT_EQ(run.exit_code, 2);
    EXPECT_THAT(run.errors, HasSubstr("--force"));
  }
  EXPECT_THAT(subscriber.SoFar(), IsEmpty());
  EXPECT_EQ(position({"initPosition", "KIT/0001"}).exit_code, 0);
  EXPECT_EQ(position({"initPosition", "KIT/0001", "KIT/0002", "--force"}).exit_code, 0);
  EXPECT_EQ(subscriber.Await(3).size(), 3U);
}

TEST_F(Refusals, NameWhatIsWrongAndSendNothing) {
  const Subscriber subscriber(broker_);
  const std::vector<Case> cases = {
      {{}, 2, "fleetpub COMMAND -h"},
      {{"puase", "KIT/0001"}, 2, "did you mean pause?"},
      {{"pause"}, 2, "name at least one robot"},
      {{"pause", "KIT"}, 2, "manufacturer/serialNumber"},
      {{"pause", "KIT/+"}, 2, "wildcards"},
      {{"pause", "KIT/"}, 2, "it is empty"},
      {{"pause", "KIT", "0001"}, 2, "did you mean KIT/0001?"},
      {{"fleet", "KIT", "0001"}, 2, "did you mean KIT/0001?"},
      {{"pause", "KIT/0001", "--rate", "0,5"}, 2, "write 0.5"},
      {{"pause", "KIT/0001", "-W", "1,5s", "--wait"}, 2, "write 1.5s"},
      {{"pause", "KIT/0001", "--debug=all"}, 2, "topics or full"},
      {{"pause", "KIT/0001", "--color", "red"}, 2, "auto, always or never"},
      {{"pause", "KIT/$x"}, 2, "reserved"},
      {{"pause", "KIT/a\nb"}, 2, "control character"},
      {{"pause", "KIT/0001", "--vda", "4"}, 2, "1.1.0, 2.0.0, 2.1.0 or 3.0.0"},
      {{"pause", "KIT/0001", "--qso", "1"}, 2, "did you mean --qos?"},
      {{"pause", "KIT/0001", "-q", "3"}, 2, "0, 1 or 2"},
      {{"pause", "KIT/0001", "-q", "1", "--qos", "1"}, 2, "--qos is given more than once"},
      {{"pause", "KIT/0001", "-q"}, 2, "--qos needs a value: 0, 1 or 2"},
      {{"pause", "KIT/0001", "--broker"}, 2, "--broker needs a value: --broker URL"},
      {{"order", "KIT/0001", "--to"}, 2, "--to needs a value: --to PLACE"},
      {{"pause", "KIT/0001", "-b", "http://x"}, 2, "not a scheme"},
      {{"pause", "KIT/0001", "-b", "mqtt://u:secret@x"}, 2, "password"},
      {{"pause", "KIT/0001", "--cafile", "ca.pem"}, 2, "is not encrypted"},
      {{"pause", "KIT/0001", "-P", "secret"}, 2, "key=text"},
      {{"pause", "KIT/0001", "--topic-template", "{manufacturer}/{topic}"}, 2, "{serial}"},
      {{"pause", "KIT/1", "KIT/2", "--id", "a"}, 2, "one target"},
      {{"pause", "KIT/0001", "--user-property", "a=b"}, 2, "add --mqtt-version 5"},
      {{"pause", "KIT/0001", "--message-expiry", "9s"}, 2, "add --mqtt-version 5"},
      {{"pause", "KIT/0001", "-V", "5", "--message-expiry", "0s"}, 2, "from 1s"},
      {{"pause", "KIT/0001", "-V", "5", "--user-property", "plain"}, 2, "NAME=VALUE"},
      {{"pick", "KIT/0001"}, 3, "never an instant action"},
      {{"action", "drop", "KIT/0001"}, 3, "never an instant action"},
      {{"downloadMap", "KIT/0001", "--vda", "2.0"}, 3, "it is one in 2.1.0, 3.0.0"},
      {{"initPosition", "KIT/0001", "--x", "nan"}, 2, "x must be a finite number"},
      {{"initPosition", "KIT/0001", "--x", "1e999"}, 2, "x must be a finite number"},
      {{"initPosition", "KIT/0001", "--theta", "3.2"}, 2, "between -π and π"},
      {{"initPosition", "KIT/0001", "--x", "1"}, 3, "needs the parameters y, theta, mapId"},
      {{"pause", "KIT/0001", "--vda", "3", "--blocking-type", "HARD"}, 3, "must be NONE"},
      {{"pause", "KIT/0001", "--id", ""}, 2, "must not be empty"},
      {{"action", "beep", "KIT/0001", "-P", "a:={"}, 2, "takes JSON"},
      {{"action", "beep", "KIT/0001", "-P", "a:=null"}, 3, "must be"},
      {{"action", "beep", "KIT/0001", "-P", "a=\xFF"}, 2, "UTF-8"},
      {{"action", "beep", "KIT/0001", "-P", "a=@/nowhere"}, 8, "/nowhere"},
  };
  for (const auto& [arguments, exit_code, sentence] : cases) {
    const Finished run = Fleetpub(arguments);
    EXPECT_EQ(run.exit_code, exit_code) << sentence << "\n" << run.errors;
    EXPECT_THAT(run.errors, AllOf(HasSubstr(sentence), Not(HasSubstr("secret"))));
    EXPECT_THAT(run.output, IsEmpty());
  }
  EXPECT_EQ(Send({"pause", "KIT/0001", "-q", "1"}).exit_code, 0);
  EXPECT_EQ(subscriber.Await(1).size(), 1U);
}

TEST_F(Refusals, AnInvalidTargetAmongSeveralStopsThemAll) {
  const Subscriber subscriber(broker_);
  EXPECT_EQ(Fleetpub({"pause", "KIT/0001", "KIT/+"}).exit_code, 2);
  EXPECT_EQ(Send({"resume", "KIT/0002", "-q", "1"}).exit_code, 0);
  const auto messages = subscriber.Await(1);
  ASSERT_EQ(messages.size(), 1U);
  EXPECT_THAT(messages[0].payload, HasSubstr("stopPause"));
}

TEST_F(Refusals, ANearlyPredefinedKeyIsSentWithAWarning) {
  const Finished run = Send({"logReport", "KIT/0001", "--reason", "x", "-P", "reasn=y"});
  EXPECT_EQ(run.exit_code, 0);
  EXPECT_THAT(run.errors, HasSubstr("did you mean reason?"));
}

TEST_F(Refusals, ARefusedConnectionIsExit4) {
  operator_.UseBroker("mqtt://127.0.0.1:" + std::to_string(FreePort()));
  const Finished run = Fleetpub({"pause", "KIT/0001"});
  EXPECT_EQ(run.exit_code, 4);
  EXPECT_THAT(run.errors, AllOf(HasSubstr("nothing was sent"), HasSubstr("connection refused")));
  const Finished json = Fleetpub({"pause", "KIT/0001", "KIT/0002", "-o", "json"});
  EXPECT_EQ(json.exit_code, 4);
  ASSERT_EQ(Lines(json.output).size(), 2U);
  EXPECT_STREQ(Json(Lines(json.output)[1])["status"].GetString(), "ERROR");
}

TEST(Login, ThatFailsSaysWhatWasTriedButNoPassword) {
  const Mosquitto broker({"allow_anonymous false", "password_file {}/users"},
                         {{"users", PasswordFile("ann", "s3cret word")}});
  Operator someone;
  someone.UseBroker(broker.Url());
  const auto file = someone.home().Write("pw", "wr0ng\n");
  const auto pause = [&](std::vector<std::string> more) {
    more.insert(more.begin(), {"pause", "KIT/0001"});
    const Finished run = someone.Fleetpub(more);
    EXPECT_EQ(run.exit_code, 4);
    EXPECT_THAT(run.errors, Not(HasSubstr("wr0ng")));
    return run.errors;
  };
  EXPECT_THAT(pause({"-u", "bob", "--password-file", file.string()}),
              HasSubstr("tried: user bob and the password of file " + file.string()));
  EXPECT_THAT(pause({"-u", "bob"}), HasSubstr("tried: user bob and no password"));
  EXPECT_THAT(pause({}), HasSubstr("tried: no user name and no password"));
  Command command = someone.Prepare({"ping", "-u", "ann"});
  command.environment.emplace_back("FLEETPUB_PASSWORD", "wr0ng");
  EXPECT_THAT(testing::Run(std::move(command)).errors,
              HasSubstr("tried: user ann and the password of FLEETPUB_PASSWORD"));
}

TEST(Login, AsksOnATerminalWhenOnlyTheUserIsNamed) {
  const Mosquitto broker({"allow_anonymous false", "password_file {}/users"},
                         {{"users", PasswordFile("ann", "s3cret word")}});
  Operator someone;
  someone.UseBroker(broker.Url());
  Terminal terminal(ShellLine(someone.Prepare({"ping", "-u", "ann"})) + "; sleep 100", 100, 20);
  ASSERT_TRUE(terminal.Await("Password:"));
  terminal.Type("s3cret word");
  terminal.Press("Enter");
  EXPECT_TRUE(terminal.Await("reachable"));
  EXPECT_THAT(terminal.Shown(), Not(HasSubstr("s3cret")));
  Terminal none(
      ShellLine(someone.Prepare({"ping", "-u", "ann", "--password-file", ""})) + "; sleep 100", 100,
      20);
  EXPECT_TRUE(none.Await("no password"));
}

TEST_F(Refusals, ShowTopicsAndMessagesWhenDebugged) {
  const Finished topics = Send({"pause", "KIT/0001", "--debug"});
  EXPECT_THAT(topics.errors, AllOf(HasSubstr("sent vda5050/v3/KIT/0001/instantActions, "),
                                   Not(HasSubstr("actionType"))));
  const Finished full = Send({"pause", "KIT/0001", "--debug=full"});
  EXPECT_THAT(full.errors, HasSubstr(R"("actionType":"startPause")"));
  const auto robot = Robot({"KIT/0001"});
  EXPECT_THAT(Fleetpub({"fleet", "--debug"}).errors,
              HasSubstr("received vda5050/v3/KIT/0001/connection, "));
}

TEST_F(Refusals, AreColouredOnlyWhereThatIsWanted) {
  const std::string escape = "\x1b[";
  EXPECT_THAT(Send({"pause", "KIT/0001"}).output, Not(HasSubstr(escape)));
  EXPECT_THAT(Send({"pause", "KIT/0001", "--color", "always"}).output, HasSubstr(escape));
  EXPECT_THAT(Send({"pause", "KIT/0001", "--color=never"}).output, Not(HasSubstr(escape)));
}

TEST(Login, IsRefusedWithExit4AndGrantedWithAPasswordFile) {
  const Mosquitto broker({"allow_anonymous false", "password_file {}/users"},
                         {{"users", PasswordFile("ann", "s3cret word")}});
  Operator ann;
  ann.UseBroker(broker.Url());
  const Finished anonymous = ann.Fleetpub({"pause", "KIT/0001"});
  EXPECT_EQ(anonymous.exit_code, 4);
  const auto file = ann.home().Write("password", "s3cret word\n");
  const Finished exposed =
      ann.Send({"pause", "KIT/0001", "-u", "ann", "--password-file", file.string()});
  EXPECT_EQ(exposed.exit_code, 0) << exposed.errors;
  EXPECT_THAT(exposed.errors, HasSubstr("chmod 600"));
  std::filesystem::permissions(file, std::filesystem::perms::owner_read);
  EXPECT_EQ(ann.Send({"pause", "KIT/0001", "-u", "ann", "--password-file", file.string()}).errors,
            "");

  Command command = ann.Prepare(WithoutLook({"pause", "KIT/0001", "-u", "ann", "--debug"}));
  command.environment.emplace_back("FLEETPUB_PASSWORD", "s3cret word");
  const Finished debugged = testing::Run(command);
  EXPECT_EQ(debugged.exit_code, 0) << debugged.errors;
  EXPECT_THAT(debugged.errors, Not(HasSubstr("s3cret")));
  EXPECT_EQ(ann.Fleetpub({"pause", "KIT/0001", "--password-file", file.string()}).exit_code, 2);
}

TEST_F(Refusals, ALedgerThatCannotBeUsedIsExit8AndSendsNothing) {
  const Subscriber subscriber(broker_);
  operator_.home().Write("ledger.db", std::string(8192, 'x'));
  const Finished corrupt = Send({"pause", "KIT/0001"});
  EXPECT_EQ(corrupt.exit_code, 8);
  EXPECT_THAT(corrupt.errors, AllOf(HasSubstr("nothing was sent"), HasSubstr("ledger.db")));
  const Finished folder = Send({"pause", "KIT/0001", "--ledger", operator_.home().path()});
  EXPECT_EQ(folder.exit_code, 8);
  const Finished good =
      Send({"resume", "KIT/0001", "-q", "1", "--ledger", operator_.home() / "good.db"});
  EXPECT_EQ(good.exit_code, 0) << good.errors;
  const auto messages = subscriber.Await(1);
  ASSERT_EQ(messages.size(), 1U);
  EXPECT_THAT(messages[0].payload, HasSubstr("stopPause"));
}

TEST_F(Refusals, CtrlCEndsWith130AndSaysWhatWasSent) {
  const BrokenBroker silent(BrokenBroker::Silent());
  operator_.UseBroker(silent.Url());
  for (const auto& [signal, code] : {std::pair(SIGINT, 130), std::pair(SIGTERM, 143)}) {
    Process run(operator_.Prepare({"pause", "KIT/0001", "--debug"}));
    ASSERT_TRUE(run.AwaitErrors("CONNECT"));
    run.Signal(signal);
    EXPECT_EQ(run.Wait(), code);
    EXPECT_THAT(run.Errors(), HasSubstr("nothing was sent"));
  }
  const BrokenBroker deaf(BrokenBroker::Answers({BrokenBroker::Connack(0)}));
  operator_.UseBroker(deaf.Url());
  Process run(operator_.Prepare(WithoutLook({"pause", "KIT/0001", "-q", "1", "--debug"})));
  ASSERT_TRUE(run.AwaitErrors("-> PUBLISH"));
  run.Signal(SIGINT);
  EXPECT_EQ(run.Wait(), 130);
  EXPECT_THAT(run.Errors(), HasSubstr("fleetpub history lists what was sent"));
}

TEST_F(Refusals, AnObjectSaysThatNothingWasSent) {
  operator_.UseBroker("mqtt://127.0.0.1:1");
  for (const std::vector<std::string>& call :
       {std::vector<std::string>{"pause", "KIT/0001"},
        {"publish", "zoneSet", "KIT/0001", "-f", operator_.home().Write("zones", "{}")}}) {
    std::vector<std::string> words = call;
    words.insert(words.end(), {"-o", "json"});
    const Finished run = Fleetpub(words);
    EXPECT_THAT(Json(run.output)["message"].GetString(), StartsWith("not sent: ")) << run.errors;
  }
}

TEST_F(Refusals, AReaderThatHasSeenEnoughIsNoTrouble) {
  Command command = operator_.Prepare({"actions"});
  const std::string actions = Binary() + " actions -o json";
  command.arguments = {"bash", "-c",
                       "set -o pipefail; " + actions + " | true; " + actions + " | head -1"};
  const Finished run = testing::Run(command);
  EXPECT_EQ(run.exit_code, 0);
  EXPECT_THAT(run.errors, IsEmpty());
}

TEST_F(Refusals, ResultsThatCannotBeWrittenAreTold) {
  const Finished looking = InShell("actions > /dev/full");
  EXPECT_EQ(looking.exit_code, 8);
  EXPECT_THAT(looking.errors, HasSubstr("could not be written"));
  const Finished sending = InShell("pause KIT/0001 --vda 3 --no-check > /dev/full");
  EXPECT_EQ(sending.exit_code, 0) << "the command was sent, whoever reads the result";
  EXPECT_THAT(sending.errors, HasSubstr("could not be written"));
}

TEST_F(Refusals, HelpThatCannotBeWrittenIsTold) {
  const Finished help = InShell("--help > /dev/full");
  EXPECT_EQ(help.exit_code, 8);
  EXPECT_THAT(help.errors, HasSubstr("could not be written"));
}

// Their numbers would be those of the connection and of the pipe that a batch listens on.
TEST_F(Refusals, ClosedStandardDescriptorsDoNoHarm) {
  const auto robot = Robot({"KIT/0001"});
  const Subscriber subscriber(broker_, "+/+/+/+/instantActions");
  const Finished closed = InShell("pause KIT/0001 --wait <&- >&-");
  EXPECT_EQ(closed.exit_code, 0) << closed.errors;
  EXPECT_THAT(closed.errors, HasSubstr("standard output: Bad file descriptor"));
  EXPECT_THAT(subscriber.Await(1), SizeIs(1));
  EXPECT_THAT(broker_.Log(), Not(AnyOf(HasSubstr("malformed"), HasSubstr("protocol error"))));
  const Finished batch = InShell("batch <&-");
  EXPECT_EQ(batch.exit_code, 8);
  EXPECT_THAT(batch.output, HasSubstr("cannot read standard input"));
  EXPECT_EQ(InShell("simulate KIT/0002 --for 100ms 2>&-").exit_code, 0);
}

TEST_F(Refusals, AHostBehindTheLetterOfHelpIsNoHelp) {
  const Finished meant = Fleetpub({"pause", "KIT/0001", "-h", "localhost"});
  EXPECT_EQ(meant.exit_code, 2);
  EXPECT_THAT(meant.errors, HasSubstr("the broker's host is --host"));
  EXPECT_EQ(Fleetpub({"pause", "KIT/0001", "-h"}).exit_code, 0);
  EXPECT_EQ(Fleetpub({"-h", "pause"}).exit_code, 0);
}

TEST_F(Refusals, WordsInTheWrongPlaceAreTold) {
  EXPECT_THAT(Fleetpub({"KIT/0001", "pause"}).errors,
              HasSubstr("the command comes before its target: fleetpub pause KIT/0001"));
  EXPECT_THAT(Fleetpub({"pause", "all"}).errors, HasSubstr("--all means every robot"));
}

}  // namespace
}  // namespace fleetpub::testing
