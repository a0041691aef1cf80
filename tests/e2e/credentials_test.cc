// Credentials as sites have them: passwords that a program prints, tokens, user names of clouds.
#include <gmock/gmock.h>
#include <sys/stat.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <mutex>
#include <thread>

#include "support/gone.h"
#include "support/operator.h"
#include "support/scripted_broker.h"

namespace fleetpub::testing {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::SizeIs;

using Variables = std::vector<std::pair<std::string, std::optional<std::string>>>;

class Credentials : public ::testing::Test {
 protected:
  [[nodiscard]] std::filesystem::path Configure(const std::string& text) const {
    const auto file = operator_.home().Write(".config/fleetpub/config.toml", text);
    chmod(file.c_str(), 0600);
    return file;
  }
  // A program that notes each of its runs, with its environment.
  [[nodiscard]] std::string Program(const std::string& prints = "hunter2") const {
    const auto file = operator_.home().Write(
        "token", "#!/bin/sh\nenv >> " + Runs() + "\necho run >> " + Runs() +
                     "\necho asking the vault >&2\nprintf '%s\\n' \"" + prints + "$1\"\n");
    chmod(file.c_str(), 0700);
    return file.string();
  }
  [[nodiscard]] std::string Runs() const { return (operator_.home() / "runs").string(); }
  [[nodiscard]] std::vector<std::string> CountRuns() const {
    std::vector<std::string> runs;
    std::ifstream file(Runs());
    for (std::string line; std::getline(file, line);) {
      if (line == "run") runs.push_back(line);
    }
    return runs;
  }
  static std::unique_ptr<Mosquitto> Guarded(const std::string& password = "hunter2") {
    return std::make_unique<Mosquitto>(
        std::vector<std::string>{"allow_anonymous false", "password_file {}/users"},
        std::vector<std::pair<std::string, std::string>>{{"users", PasswordFile("ann", password)}});
  }
  [[nodiscard]] std::string Login(const std::string& url) const {
    return "broker = \"" + url + "\"\nusername = \"ann\"\npassword_command = [\"" + Program() +
           "\"]\n";
  }
  Finished Run(std::vector<std::string> arguments, const Variables& variables = {}) {
    Command command = operator_.Prepare(std::move(arguments));
    command.environment.insert(command.environment.end(), variables.begin(), variables.end());
    return fleetpub::testing::Run(std::move(command));
  }

  Operator operator_;
};

const std::vector<std::string> kPause = WithoutLook({"pause", "KIT/0001", "-q", "1"});
const std::vector<std::string> kSend = WithoutLook({"pause", "KIT/0001"});

std::vector<std::string> With(std::vector<std::string> words, std::vector<std::string> more) {
  words.insert(words.end(), more.begin(), more.end());
  return words;
}

// ── password_command ──

TEST_F(Credentials, OfEachProfileComeFromItsOwnProgram) {
  std::string configuration = "default_profile = \"north\"\n";
  std::vector<std::unique_ptr<Mosquitto>> brokers;
  for (const std::string name : {"north", "south"}) {
    brokers.push_back(Guarded("hunter2" + name));
    configuration += "[profile." + name + "]\nbroker = \"" + brokers.back()->Url() +
                     "\"\nusername = \"ann\"\npassword_command = [\"" + Program() + "\", \"" +
                     name + "\"]\n";
  }
  const auto file = Configure(configuration);
  const Finished run = Run({"doctor", "--config", file.string(), "--for", "100ms"});
  for (const std::string& reached : {brokers[0]->Url() + " (profile north): reachable",
                                     brokers[1]->Url() + " (profile south): reachable"}) {
    EXPECT_THAT(run.output, HasSubstr(reached)) << run.errors;
  }
  EXPECT_THAT(CountRuns(), SizeIs(2));
}

TEST_F(Credentials, AProgramPrintsThePassword) {
  const auto broker = Guarded();
  const auto file = Configure("[profile.north]\n" + Login(broker->Url()));
  const Finished run = Run(With(kPause, {"--profile", "north", "-v", "--debug=full"}));
  EXPECT_EQ(run.exit_code, 0) << run.errors;
  EXPECT_THAT(run.errors, AllOf(HasSubstr("asking the vault"), Not(HasSubstr("hunter2"))));
  EXPECT_THAT(run.output, Not(HasSubstr("hunter2")));
  const auto other = Guarded("another");
  const auto again = Configure("[profile.north]\n" + Login(other->Url()));
  const Finished refused = Run(With(kPause, {"--profile", "north"}));
  EXPECT_EQ(refused.exit_code, 4);
  EXPECT_THAT(refused.errors, AllOf(HasSubstr("the password of password_command (profile north of"),
                                    Not(HasSubstr("hunter2"))));
}

TEST_F(Credentials, AProgramIsRunOncePerProcess) {
  const auto broker = Guarded();
  const auto file = Configure(Login(broker->Url()));
  Process robot(operator_.Prepare({"simulate", "KIT/0001"}));
  ASSERT_TRUE(robot.AwaitErrors("online")) << robot.Errors();
  EXPECT_THAT(CountRuns(), SizeIs(1));
  EXPECT_EQ(Run({"charge", "KIT/*", "--wait"}).exit_code, 0);
  EXPECT_THAT(CountRuns(), SizeIs(2));
  Process watch(operator_.Prepare({"await", "KIT/0001", "paused=true"}));
  ASSERT_TRUE(broker->AwaitLog("KIT/0001/state")) << watch.Errors();
  broker->Kill();
  broker->Restart();
  ASSERT_TRUE(broker->AwaitLog("KIT/0001/state")) << watch.Errors();
  EXPECT_THAT(CountRuns(), SizeIs(3)) << "it connected twice";
}

TEST_F(Credentials, AProgramIsNotRunWhereNothingIsConnectedTo) {
  const auto file = Configure(Login("mqtt://127.0.0.1:1"));
  for (const std::vector<std::string>& words :
       std::vector<std::vector<std::string>>{{"pause", "KIT/0001", "--dry-run", "--offline"},
                                             {"config", "show"},
                                             {"config", "check"},
                                             {"history"},
                                             {"actions"},
                                             {"pause", "--help"},
                                             {"pause", "KIT/+"}}) {
    static_cast<void>(Run(words));
  }
  EXPECT_THAT(CountRuns(), IsEmpty());
  const Finished shown = Run({"config", "show"});
  EXPECT_THAT(shown.output, AllOf(HasSubstr("password_command"), HasSubstr(Program()),
                                  HasSubstr("********"), Not(HasSubstr("hunter2"))));
}

TEST_F(Credentials, OtherPasswordsGoBeforeTheProgram) {
  const auto broker = Guarded("another");
  const auto file = Configure(Login(broker->Url()));
  const auto secret = operator_.home().Write("secret", "another\n");
  chmod(secret.c_str(), 0600);
  EXPECT_EQ(Run(kPause, {{"FLEETPUB_PASSWORD", "another"}}).exit_code, 0);
  EXPECT_EQ(Run(kPause, {{"FLEETPUB_PASSWORD_FILE", secret.string()}}).exit_code, 0);
  EXPECT_EQ(Run(With(kPause, {"--password-file", secret.string()})).exit_code, 0);
  EXPECT_EQ(Run(With(kPause, {"--password-file", ""})).exit_code, 4);
  const auto credentials = operator_.home().Write("systemd/fleetpub.password", "another\n");
  EXPECT_EQ(Run(kPause, {{"CREDENTIALS_DIRECTORY", credentials.parent_path().string()}}).exit_code,
            0);
  EXPECT_THAT(CountRuns(), IsEmpty());
  EXPECT_EQ(Run(kPause).exit_code, 4);
  EXPECT_THAT(CountRuns(), SizeIs(1));
}

TEST_F(Credentials, OfTwoWaysToAPasswordTheProfilesHolds) {
  const auto broker = Guarded();
  const auto secret = operator_.home().Write(".config/fleetpub/wrong", "wrong\n");
  chmod(secret.c_str(), 0600);
  const std::string head = "broker = \"" + broker->Url() + "\"\nusername = \"ann\"\n";
  const std::string by_program = "password_command = [\"" + Program() + "\"]\n";
  const auto first = Configure(head + "password_file = \"wrong\"\n[profile.p]\n" + by_program);
  EXPECT_EQ(Run(With(kPause, {"--profile", "p"})).exit_code, 0);
  EXPECT_EQ(Run(kPause).exit_code, 4);
  const auto second = Configure(head + by_program + "[profile.p]\npassword_file = \"wrong\"\n");
  EXPECT_EQ(Run(kPause).exit_code, 0);
  EXPECT_EQ(Run(With(kPause, {"--profile", "p"})).exit_code, 4);
  EXPECT_THAT(CountRuns(), SizeIs(2));
}

TEST_F(Credentials, AProgramSeesNoSecretOfOurs) {
  const auto broker = Guarded();
  const auto file = Configure(Login(broker->Url()));
  const Finished run = Run(
      kPause, {{"FLEETPUB_PROXY", "http://me:open-sesame@127.0.0.1:1"}, {"STILL_THERE", "yes"}});
  EXPECT_EQ(run.exit_code, 4);
  std::ifstream seen(Runs());
  const std::string environment(std::istreambuf_iterator<char>(seen), {});
  EXPECT_THAT(environment, AllOf(HasSubstr("STILL_THERE=yes"), Not(HasSubstr("sesame"))));
}

TEST_F(Credentials, AProgramThatFailsIsToldAndNothingIsSent) {
  const auto broker = Guarded();
  const auto file = Configure("broker = \"" + broker->Url() +
                              "\"\nusername = \"ann\"\npassword_command = [\"sh\", \"-c\", \"echo "
                              "hunter2; echo locked >&2; exit 7\"]\n");
  const Finished run = Run(kPause);
  EXPECT_EQ(run.exit_code, 8);
  EXPECT_THAT(run.errors, AllOf(HasSubstr("locked\n"), HasSubstr(file.string() + ":3"),
                                HasSubstr("exit code 7"), Not(HasSubstr("hunter2"))));
  EXPECT_THAT(broker->Log(), Not(HasSubstr("New connection")));
}

// It may wait for a vault, or a person; whoever ends us does not.
TEST_F(Credentials, AProgramEndsWithUs) {
  const auto broker = Guarded();
  const std::string pid = (operator_.home() / "pid").string();
  const auto file = Configure("broker = \"" + broker->Url() +
                              "\"\nusername = \"ann\"\npassword_command = [\"sh\", \"-c\", \""
                              "sleep 60 & echo $! > " +
                              pid + ".new; mv " + pid + ".new " + pid + "; wait\"]\n");
  const std::string scenario =
      operator_.home()
          .Write("s.toml", "[[test]]\nname = \"x\"\nsteps = [{ simulate = \"KIT/0001\" }]\n")
          .string();
  for (const auto& words : std::vector<std::vector<std::string>>{kPause,
                                                                 {"fleet"},
                                                                 {"simulate", "KIT/0001"},
                                                                 {"conform", "KIT/0001"},
                                                                 {"test", scenario}}) {
    for (const auto& [signal, code] : {std::pair(SIGINT, 130), {SIGTERM, 143}}) {
      SCOPED_TRACE(words.front());
      Command command = operator_.Prepare(words);
      command.arguments.insert(command.arguments.begin(), "setsid");  // away from any terminal
      Process run(std::move(command));
      while (!std::filesystem::exists(pid) && run.Running()) std::this_thread::yield();
      run.Signal(signal);
      EXPECT_EQ(run.Wait(std::chrono::seconds(5)), code);
      EXPECT_THAT(run.Errors(), HasSubstr("nothing was sent"));
      EXPECT_TRUE(HasGone(pid));
      std::filesystem::remove(pid);
    }
  }
}

TEST_F(Credentials, AProgramOfAFileThatOthersCanChangeIsRefused) {
  const auto broker = Guarded();
  const auto file = Configure(Login(broker->Url()));
  const auto refused = [&](const std::string& words) {
    for (const std::vector<std::string>& call : {kPause,
                                                 {"config", "show"},
                                                 {"config", "check"},
                                                 With(kPause, {"--config", file.string()})}) {
      const Finished run = Run(call);
      EXPECT_EQ(run.exit_code, 2) << words;
      EXPECT_THAT(run.errors + run.output,
                  AllOf(HasSubstr(file.string() + ":3:1: password_command: "), HasSubstr(words)));
    }
    EXPECT_THAT(CountRuns(), IsEmpty());
  };
  chmod(file.c_str(), 0660);
  refused("chmod g-w " + file.string());
  chmod(file.c_str(), 0600);
  for (const auto& folder : {file.parent_path(), file.parent_path().parent_path()}) {
    chmod(folder.c_str(), 0770);
    refused("chmod g-w " + folder.string());
    chmod(folder.c_str(), 0700);
  }
  EXPECT_EQ(Run(kPause).exit_code, 0);
  constexpr uid_t kNobody = 65534;
  if (chown(file.c_str(), kNobody, 0) != 0) return;
  const Finished run = Run(With(kPause, {"--config", file.string()}));
  EXPECT_EQ(run.exit_code, 2) << "root may name anybody's file, but runs nobody's program";
  EXPECT_THAT(run.errors, HasSubstr("the file belongs to nobody"));
}

TEST_F(Credentials, AProgramsPasswordGoesToItsOwnBrokerAlone) {
  const auto north = Guarded();
  const auto other = Guarded();
  const auto file = Configure("[profile.north]\n" + Login(north->Url()));
  const Finished run = Run(With(kPause, {"--profile", "north", "-b", other->Url(), "-u", "ann"}));
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_THAT(run.errors, HasSubstr("password_command of profile north"));
  EXPECT_THAT(other->Log(), Not(HasSubstr("New connection")));
  EXPECT_THAT(CountRuns(), IsEmpty());
  EXPECT_EQ(Run(With(kPause, {"--profile", "north", "-b", other->Url(), "-u", "ann",
                              "--password-file", ""}))
                .exit_code,
            4);
  EXPECT_THAT(CountRuns(), IsEmpty());
}

// ── enhanced authentication ──

// Keeps the CONNECT packet, and answers.
class Listening {
 public:
  explicit Listening(std::string answer)
      : answer_(std::move(answer)), broker_([this](int socket) {
          PacketReader reader(socket);
          while (const auto packet = reader.Next()) {
            if (packet->type != 1) continue;
            const std::lock_guard lock(mutex_);
            connect_ = packet->body;
            WriteTo(socket, answer_);
          }
        }) {}
  [[nodiscard]] std::string Url() const { return broker_.Url(); }
  [[nodiscard]] std::string Connect() {
    const std::lock_guard lock(mutex_);
    return connect_;
  }

 private:
  std::string answer_;
  std::mutex mutex_;
  std::string connect_;
  BrokenBroker broker_;
};

// As §3.1.2.11 has it.
std::string Property(char code, const std::string& value) {
  return std::string{code, static_cast<char>(value.size() >> 8),
                     static_cast<char>(value.size() & 0xFF)} +
         value;
}

TEST_F(Credentials, AMethodAndItsDataAreSentAsTheyAre) {
  const std::string token = "eyJ\xff.\x01\n.sig";
  const auto file = operator_.home().Write("token.jwt", token + "\r\n");
  chmod(file.c_str(), 0600);
  Listening broker(BrokenBroker::Connack5(0));
  const Finished run = Run(With(kSend, {"-b", broker.Url(), "-V", "5", "--auth-method", "K8S-SAT",
                                        "--auth-data-file", file.string(), "-v", "--debug=full"}));
  EXPECT_EQ(run.exit_code, 0) << run.errors;
  EXPECT_THAT(run.errors, Not(HasSubstr("eyJ")));
  EXPECT_THAT(broker.Connect(),
              AllOf(HasSubstr(Property(0x15, "K8S-SAT")), HasSubstr(Property(0x16, token))));
  EXPECT_EQ(Run(With(kSend, {"-b", broker.Url(), "-V", "5"}), {{"FLEETPUB_AUTH_METHOD", "ALONE"}})
                .exit_code,
            0);
  EXPECT_THAT(broker.Connect(), AllOf(HasSubstr(Property(0x15, "ALONE") + std::string("\0", 1)),
                                      Not(HasSubstr("eyJ"))));
}

TEST_F(Credentials, AMethodThatCannotBeSentIsRefused) {
  const auto file = operator_.home().Write("token.jwt", "x");
  chmod(file.c_str(), 0600);
  const auto refused = [&](std::vector<std::string> more, int code, const std::string& words) {
    const Finished run = Run(With(With(kPause, {"-b", "mqtt://127.0.0.1:1"}), std::move(more)));
    EXPECT_EQ(run.exit_code, code) << run.errors;
    EXPECT_THAT(run.errors, HasSubstr(words));
  };
  refused({"--auth-method", "TOKEN"}, 2, "--mqtt-version 5");
  refused({"-V", "5", "--auth-data-file", file.string()}, 2, "--auth-method");
  refused({"-V", "5", "--auth-method", "TOKEN", "--auth-data-file", "/nowhere"}, 8, "/nowhere");
  chmod(file.c_str(), 0644);
  refused({"-V", "5", "--auth-method", "TOKEN", "--auth-data-file", file.string()}, 4,
          "chmod 600 " + file.string());
}

TEST_F(Credentials, AMethodsDataGoToTheirOwnBrokerAlone) {
  Listening other(BrokenBroker::Connack5(0));
  operator_.home().Write(".config/fleetpub/token", "sesame");
  const auto file = Configure(
      "[profile.north]\nbroker = \"mqtt://127.0.0.1:1\"\nmqtt_version = 5\nauth_method = "
      "\"TOKEN\"\nauth_data_file = \"token\"\n");
  const auto call = With(kSend, {"--profile", "north", "-b", other.Url()});
  const Finished run = Run(call);
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_THAT(run.errors, HasSubstr("auth_method of profile north"));
  const Finished half = Run(With(call, {"--auth-method", "MINE"}));
  EXPECT_EQ(half.exit_code, 2);
  EXPECT_THAT(half.errors, HasSubstr("auth_data_file of profile north"));
  EXPECT_THAT(other.Connect(), IsEmpty());
  EXPECT_EQ(Run(With(call, {"--auth-method", "", "--auth-data-file", ""})).exit_code, 0);
  EXPECT_THAT(other.Connect(), Not(HasSubstr("TOKEN")));
}

#ifdef FLEETPUB_TOKEN_PLUGIN
class TokenBroker : public Credentials {
 protected:
  TokenBroker() { operator_.UseBroker(broker_.Url()); }
  [[nodiscard]] Finished Ping(const std::string& method, const std::string& token) {
    const auto file = operator_.home().Write("data", token);
    chmod(file.c_str(), 0600);
    return Run({"ping", "-V", "5", "--auth-method", method, "--auth-data-file", file.string()});
  }

  Mosquitto broker_{{"allow_anonymous false", "plugin " FLEETPUB_TOKEN_PLUGIN}};
};

TEST_F(TokenBroker, TakesARightTokenOnly) {
  EXPECT_EQ(Ping("TOKEN", "sesame\n").exit_code, 0) << broker_.Log();
  const Finished wrong = Ping("TOKEN", "sesam");
  EXPECT_EQ(wrong.exit_code, 4);
  EXPECT_THAT(wrong.errors, AllOf(HasSubstr("not authorized"), HasSubstr("--auth-data-file"),
                                  HasSubstr("method TOKEN with the data of")));
  const Finished unknown = Ping("SCRAM-SHA-1", "sesame");
  EXPECT_EQ(unknown.exit_code, 4);
  EXPECT_THAT(unknown.errors, HasSubstr("bad authentication method"));
}

TEST_F(TokenBroker, IsNotAnsweredWhenItAsksForMore) {
  const Finished run = Ping("TWO-STEP", "sesame");
  EXPECT_EQ(run.exit_code, 4);
  EXPECT_THAT(run.errors, AllOf(HasSubstr("further step"), HasSubstr("--auth-method")));
}
#endif

// ── user names and passwords of clouds ──

TEST_F(Credentials, AQueryInAUserNameIsSentAsItIs) {
  const std::string user =
      "ann?x-amz-customauthorizer-name=Gate&x-amz-customauthorizer-signature=a%2Bb%3D=&token=a/b";
  Listening broker(BrokenBroker::Connack(0));
  const auto sent = [&] {
    return std::string{static_cast<char>(user.size() >> 8), static_cast<char>(user.size())} + user;
  }();
  EXPECT_EQ(Run(With(kSend, {"-b", broker.Url(), "-u", user, "--password-file", ""})).exit_code, 0);
  EXPECT_THAT(broker.Connect(), HasSubstr(sent));
  const auto file = Configure("broker = \"" + broker.Url() + "\"\nusername = \"" + user + "\"\n");
  EXPECT_EQ(Run(kSend).exit_code, 0);
  EXPECT_THAT(broker.Connect(), HasSubstr(sent));
}

}  // namespace
}  // namespace fleetpub::testing
