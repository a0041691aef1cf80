// Whose login goes to which broker, and where a secret can be read.
#include <gmock/gmock.h>
#include <sys/resource.h>
#include <sys/stat.h>

#include <fstream>
#include <sstream>

#include "mqtt/certificates.h"
#include "support/operator.h"

namespace fleetpub::testing {
namespace {

using mqtt::Certificates;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

using Variables = std::vector<std::pair<std::string, std::optional<std::string>>>;

std::vector<std::string> Pause(std::vector<std::string> more) {
  more.insert(more.begin(), {"pause", "KIT/0001", "-q", "1"});
  return WithoutLook(std::move(more));
}

class Logins : public ::testing::Test {
 protected:
  // A broker that takes this one login.
  static std::unique_ptr<Mosquitto> Guarded(const std::string& user) {
    return std::make_unique<Mosquitto>(
        std::vector<std::string>{"allow_anonymous false", "password_file {}/users"},
        std::vector<std::pair<std::string, std::string>>{{"users", PasswordFile(user, "hunter2")}});
  }
  [[nodiscard]] std::string Secret(const std::string& name = "password",
                                   const std::string& text = "hunter2\n") const {
    const auto file = operator_.home().Write(name, text);
    chmod(file.c_str(), 0600);
    return file.string();
  }
  void Configure(const std::string& text) const {
    chmod(operator_.home().Write(".config/fleetpub/config.toml", text).c_str(), 0600);
  }
  [[nodiscard]] std::string Login(const std::string& user = "ann") const {
    return "username = \"" + user + "\"\npassword_file = \"" + Secret() + "\"\n";
  }
  static std::string BrokerLine(const Mosquitto& broker) {
    return "broker = \"" + broker.Url() + "\"\n";
  }
  [[nodiscard]] int Run(std::vector<std::string> arguments, const Variables& variables = {}) {
    Command command = operator_.Prepare(std::move(arguments));
    command.environment.insert(command.environment.end(), variables.begin(), variables.end());
    const Finished run = fleetpub::testing::Run(std::move(command));
    errors_ = run.errors;
    return run.exit_code;
  }
  // Exit 2, these words, and not even a connection.
  void ExpectRefused(const Mosquitto& broker, std::vector<std::string> arguments,
                     const std::string& words, const Variables& variables = {}) {
    EXPECT_EQ(Run(std::move(arguments), variables), 2) << errors_;
    EXPECT_THAT(errors_, HasSubstr(words));
    EXPECT_THAT(broker.Log(), Not(HasSubstr("New connection")));
  }

  Operator operator_;
  std::string errors_;
};

TEST_F(Logins, OfAProfileGoToItsBrokerAlone) {
  const auto north = Guarded("ann");
  const auto other = Guarded("ann");
  const std::string url = other->Url();
  Configure("[profile.north]\n" + BrokerLine(*north) + Login());
  const std::string why = "username of profile north";
  ExpectRefused(*other, Pause({"--profile", "north", "-b", url}), why);
  ExpectRefused(*other, Pause({"-b", url}), why, {{"FLEETPUB_PROFILE", "north"}});
  ExpectRefused(*other, {"ping", "--profile", "north", "-b", url}, why);
  ExpectRefused(*other, Pause({"--profile", "north", "-b", north->Url(), "-b", url}), why);
  ExpectRefused(*other, Pause({"--profile", "north", "-b", url, "-u", "ann"}),
                "password_file of profile north");
  EXPECT_EQ(Run(Pause({"--profile", "north"})), 0) << errors_;
  EXPECT_EQ(Run(Pause({"--profile", "north", "-b", north->Url()})), 0) << errors_;
}

TEST_F(Logins, OfADefaultProfileGoToItsBrokerAlone) {
  const auto north = Guarded("ann");
  const auto other = Guarded("ann");
  Configure("default_profile = \"north\"\n[profile.north]\n" + BrokerLine(*north) + Login());
  const std::string why = "username of profile north";
  ExpectRefused(*other, Pause({}), why, {{"FLEETPUB_BROKER", other->Url()}});
  ExpectRefused(*other, Pause({"--host", "127.0.0.1", "-p", std::to_string(other->port())}), why);
  ExpectRefused(*other, Pause({}), why,
                {{"FLEETPUB_HOST", "127.0.0.1"}, {"FLEETPUB_PORT", std::to_string(other->port())}});
  EXPECT_EQ(Run(Pause({"--host", "127.0.0.1", "-p", std::to_string(north->port())})), 0);
}

TEST_F(Logins, OfTheirOwnGoToAnyBroker) {
  const auto north = Guarded("ann");
  const auto other = Guarded("bob");
  const Mosquitto open;
  Configure("[profile.north]\n" + BrokerLine(*north) + Login());
  const Variables own = {{"FLEETPUB_PASSWORD", "hunter2"}};
  const std::string url = other->Url();
  EXPECT_EQ(Run(Pause({"--profile", "north", "-b", url, "-u", "bob"}), own), 0) << errors_;
  EXPECT_EQ(Run(Pause({"--profile", "north", "-b", other->Url("mqtt", "bob@127.0.0.1")}), own), 0)
      << errors_;
  EXPECT_EQ(Run(Pause({"--profile", "north", "-b", url, "-u", "bob", "--password-file",
                       Secret("another")})),
            0)
      << errors_;
  EXPECT_EQ(Run(Pause({"--profile", "north", "-b", open.Url(), "-u", "", "--password-file", ""})),
            0)
      << errors_;
}

TEST_F(Logins, OutsideOfProfilesGoToAllThatAreConfigured) {
  const auto north = Guarded("ann");
  const auto south = Guarded("ann");
  const auto other = Guarded("ann");
  Configure(Login() + "[profile.north]\n" + BrokerLine(*north) + "[profile.south]\n" +
            BrokerLine(*south));
  EXPECT_EQ(Run(Pause({"--profile", "north"})), 0) << errors_;
  EXPECT_EQ(Run(Pause({"-b", south->Url()})), 0) << errors_;
  ExpectRefused(*other, Pause({"-b", other->Url()}), "username of ");
  Configure(Login());  // for no broker that it names
  EXPECT_EQ(Run(Pause({"-b", other->Url()})), 0) << errors_;
}

TEST_F(Logins, ByCertificateStayToo) {
  const auto& files = Certificates::Get();
  const Mosquitto other(files.Subscription());
  const Mosquitto plain;
  Configure("[profile.north]\nbroker = \"mqtts://north.example\"\ncafile = \"" + files / "ca.crt" +
            "\"\ncert = \"" + files / "client.crt" + "\"\nkey = \"" + files / "client.key" +
            "\"\nkey_password_file = \"" + Secret("key-password", "secret\n") + "\"\n");
  const std::string url = other.Url("mqtts", "localhost");
  ExpectRefused(other, Pause({"--profile", "north", "-b", url}), "cert of profile north");
  EXPECT_EQ(Run(Pause({"--profile", "north", "-b", url, "--cert", "", "--key", "",
                       "--key-password-file", ""})),
            0)
      << errors_;
  EXPECT_EQ(Run(Pause({"--profile", "north", "-b", plain.Url()})), 0) << errors_;
}

TEST_F(Logins, AreNotSentUnverifiedBecauseAnotherBrokersMayBe) {
  const Mosquitto other(Certificates::Get().Subscription());
  const std::string url = other.Url("mqtts", "localhost");
  Configure(
      "[profile.north]\nbroker = \"mqtts://north.example\"\nallow_insecure = true\n"
      "insecure = true\n");
  ExpectRefused(other, Pause({"--profile", "north", "-b", url}), "insecure of profile north");
  EXPECT_EQ(Run(Pause({"--profile", "north", "-b", url, "--insecure"})), 0) << errors_;
}

TEST_F(Logins, AProfileThatIsNamedMeansItsBroker) {
  const Mosquitto north;
  const Mosquitto other;
  const std::string port = std::to_string(other.port());
  Configure("[profile.north]\n" + BrokerLine(north));
  const std::string why = "profile north has the broker";
  const auto refused = [&](std::vector<std::string> arguments, const Variables& variables) {
    ExpectRefused(other, Pause(std::move(arguments)), why, variables);
  };
  refused({}, {{"FLEETPUB_PROFILE", "north"}, {"FLEETPUB_BROKER", other.Url()}});
  refused({"--profile", "north"}, {{"FLEETPUB_BROKER", other.Url()}});
  refused({"--profile", "north", "--host", "127.0.0.1", "-p", port}, {});
  refused({"--profile", "north", "-p", port}, {{"FLEETPUB_HOST", "127.0.0.1"}});
  refused({"--profile", "north", "--host", "127.0.0.1"}, {{"FLEETPUB_PORT", port}});
  refused({"--host", "127.0.0.1", "-p", port}, {{"FLEETPUB_PROFILE", "north"}});
  // Its own broker in other words, and another one whole.
  EXPECT_EQ(
      Run(Pause({"--profile", "north", "--host", "127.0.0.1", "-p", std::to_string(north.port())})),
      0);
  EXPECT_EQ(Run(Pause({"-b", other.Url()}), {{"FLEETPUB_PROFILE", "north"}}), 0) << errors_;
}

TEST_F(Logins, StayInTheListThatIsEncrypted) {
  const auto& files = Certificates::Get();
  const Mosquitto wrong(files.Subscription("other.crt"));
  const Mosquitto right(files.Subscription());
  const Mosquitto plain;
  const std::vector<std::string> with = {"-u", "ann", "--cafile", files / "ca.crt"};
  const auto pause = [&](std::vector<std::string> more) {
    more.insert(more.end(), with.begin(), with.end());
    return Run(Pause(std::move(more)), {{"FLEETPUB_PASSWORD", "hunter2"}});
  };
  const std::string url = wrong.Url("mqtts", "localhost");
  EXPECT_EQ(pause({"-b", url, "-b", plain.Url()}), 2) << errors_;
  EXPECT_EQ(pause({"-b", url, "-b", right.Url("mqtts", "localhost")}), 4) << errors_;
  EXPECT_THAT(errors_, HasSubstr("no other broker is tried"));
  for (const Mosquitto* broker : {&wrong, &right, &plain}) {
    EXPECT_THAT(broker->Log(), Not(HasSubstr("New client connected")));
  }
}

// ── where a secret can be read ──

TEST_F(Logins, OfAProxyAreNotInTheArguments) {
  for (const std::string form :
       {"--proxy=http://me:hunter2@127.0.0.1:1", "--proxy=http://127.0.0.1:1@me:hunter2"}) {
    EXPECT_EQ(Run(Pause({form, "-b", "mqtt://127.0.0.1:1"})), 2);
    EXPECT_THAT(errors_, AllOf(HasSubstr("FLEETPUB_PROXY"), Not(HasSubstr("hunter2"))));
  }
  EXPECT_EQ(Run(Pause({"-b", "mqtt://127.0.0.1:1"}),
                {{"FLEETPUB_PROXY", "http://me:hunter2@127.0.0.1:1"}}),
            4);
  EXPECT_THAT(errors_, AllOf(HasSubstr("the proxy 127.0.0.1:1"), Not(HasSubstr("hunter2"))));
}

TEST_F(Logins, LeaveTheEnvironmentOnceTheyAreRead) {
  const auto broker = Guarded("ann");
  Command command = operator_.Prepare({"simulate", "KIT/0001", "-b", broker->Url(), "-u", "ann"});
  command.environment.emplace_back("FLEETPUB_PASSWORD", "hunter2");
  command.environment.emplace_back("FLEETPUB_INTERFACE", "still-there");
  Process robot(std::move(command));
  ASSERT_TRUE(robot.AwaitErrors("online")) << robot.Errors();
  std::ostringstream environment;
  environment << std::ifstream("/proc/" + std::to_string(robot.pid()) + "/environ").rdbuf();
  EXPECT_THAT(environment.str(), AllOf(HasSubstr("still-there"), Not(HasSubstr("hunter2"))));
}

// The variable is gone once it is read: one connection has to do.
TEST_F(Logins, OfTheEnvironmentServeEveryStepOfACommand) {
  const auto broker = Guarded("ann");
  operator_.UseBroker(broker->Url());
  const Variables own = {{"FLEETPUB_PASSWORD", "hunter2"}};
  Command simulate = operator_.Prepare({"simulate", "KIT/0001", "-u", "ann"});
  simulate.environment.insert(simulate.environment.end(), own.begin(), own.end());
  Process robot(simulate);
  ASSERT_TRUE(robot.AwaitErrors("online")) << robot.Errors();
  EXPECT_EQ(Run({"await", "KIT/*", "connection", "connectionState=ONLINE", "-u", "ann"}, own), 0)
      << errors_;
  EXPECT_EQ(Run({"charge", "KIT/*", "--wait", "-u", "ann"}, own), 0) << errors_;
  EXPECT_EQ(Run({"fleet", "-u", "ann", "--state-wait", "100ms"}, own), 0) << errors_;
}

TEST_F(Logins, LeaveNoCore) {
  const Mosquitto broker;
  for (const std::string limit : {"ulimit -S -c 0", "ulimit -S -c $(ulimit -H -c)"}) {
    Command command = operator_.Prepare({"simulate", "KIT/0001", "-b", broker.Url()});
    std::string call = limit + "; exec \"$@\"";
    command.arguments.insert(command.arguments.begin(), {"bash", "-c", call, "-"});
    Process robot(std::move(command));
    ASSERT_TRUE(robot.AwaitErrors("online")) << robot.Errors();
    rlimit core{};
    ASSERT_EQ(prlimit(robot.pid(), RLIMIT_CORE, nullptr, &core), 0);
    EXPECT_LE(core.rlim_cur, 1U);
  }
}

}  // namespace
}  // namespace fleetpub::testing
