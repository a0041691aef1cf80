// TLS that must not come about: which check failed, what to do, and nothing sent.
#include <gmock/gmock.h>

#include "mqtt/certificates.h"
#include "support/broken_broker.h"
#include "support/free_port.h"
#include "support/operator.h"

namespace fleetpub::testing {
namespace {

using mqtt::Certificates;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr const char* kNoCertificate = "it asks for a certificate of ours: give --cert and --key";
constexpr const char* kWrongCertificate = "it does not accept our certificate";

class TlsFailures : public ::testing::Test {
 protected:
  [[nodiscard]] Finished Pause(const std::string& url, std::vector<std::string> more = {}) const {
    more.insert(more.begin(),
                {"pause", "KIT/0001", "-q", "1", "-b", url, "--quiet", "--connect-timeout", "5s"});
    return operator_.Send(std::move(more));
  }
  // Exit 4, these words, and no message at the broker.
  void ExpectRefusal(const Mosquitto& broker, const Finished& run, const std::string& words) const {
    EXPECT_EQ(run.exit_code, 4) << words << run.output;
    EXPECT_THAT(run.errors, AllOf(HasSubstr("nothing was sent"), HasSubstr(words)));
    EXPECT_THAT(broker.Log(), Not(HasSubstr("Received PUBLISH")));
  }
  static std::vector<std::string> Trusting(const std::string& name = "ca.crt") {
    return {"--cafile", Certificates::Get() / name};
  }

  // The certificate of ours that is shown, and its key; "": none.
  [[nodiscard]] std::vector<std::string> Showing(const std::string& certificate,
                                                 const std::string& key) const {
    auto arguments = Trusting();
    if (certificate.empty()) return arguments;
    const auto& files = Certificates::Get();
    const auto password = operator_.home().Write("key-password", "secret\n");
    std::filesystem::permissions(
        password, std::filesystem::perms::owner_read | std::filesystem::perms::owner_write);
    arguments.insert(arguments.end(), {"--cert", files / certificate, "--key", files / key,
                                       "--key-password-file", password.string()});
    return arguments;
  }

  Operator operator_;
};

TEST_F(TlsFailures, OnTheWrongPortNameTheRightScheme) {
  const Mosquitto tls(Certificates::Get().Subscription());
  const Mosquitto plain;
  ExpectRefusal(tls, Pause(tls.Url("mqtt", "localhost")), "a port for TLS (mqtts://)");
  ExpectRefusal(plain, Pause(plain.Url("mqtts", "localhost"), Trusting()),
                "mqtt:// instead of mqtts://");
}

TEST_F(TlsFailures, OfTheBrokersCertificateNameTheCheck) {
  const auto& files = Certificates::Get();
  const Mosquitto good(files.Subscription());
  const Mosquitto expired(files.Subscription("expired.crt"));
  const Mosquitto other(files.Subscription("other.crt"));
  const Mosquitto self(files.Subscription("self.crt"));
  const std::tuple<const Mosquitto&, std::string, std::string> cases[] = {
      {expired, "ca.crt", "its certificate has expired"},
      {other, "ca.crt", "its certificate is for other.example, not for localhost"},
      {self, "ca.crt", "self-signed"},
      {good, "stranger.crt", "from an authority that is not trusted here"},
  };
  for (const auto& [broker, authority, words] : cases) {
    const std::string url = broker.Url("mqtts", "localhost");
    ExpectRefusal(broker, Pause(url, Trusting(authority)), words);
    // A user name and a password went nowhere either.
    EXPECT_THAT(broker.Log(), Not(HasSubstr("New client connected")));
  }
  ExpectRefusal(good, Pause(good.Url("mqtts", "localhost")), "not trusted here");
  auto named = Trusting();
  named.insert(named.end(), {"--tls-server-name", "other.example"});
  const Finished by_name = Pause(other.Url("mqtts", "localhost"), named);
  EXPECT_EQ(by_name.exit_code, 0) << by_name.errors;
  const Finished by_address = Pause(other.Url("mqtts"), named);
  EXPECT_EQ(by_address.exit_code, 0) << by_address.errors;
  ExpectRefusal(good, Pause(good.Url("mqtts", "localhost"), named), "not for other.example");
  EXPECT_EQ(Pause(good.Url("mqtts", "localhost"), Trusting()).exit_code, 0);
  EXPECT_EQ(Pause(self.Url("mqtts", "localhost"), Trusting("self.crt")).exit_code, 0);
}

TEST_F(TlsFailures, OfANameThatIsNoneAreSaidBeforeConnecting) {
  const std::string secure = "mqtts://127.0.0.1:1";
  for (const std::string& name : {std::string(300, 'a'), std::string("broker.example:8883"),
                                  std::string("mqtts://broker.example"), std::string("a b")}) {
    const Finished run = operator_.Fleetpub({"ping", "-b", secure, "--tls-server-name", name});
    EXPECT_EQ(run.exit_code, 2) << name;
    EXPECT_THAT(run.errors, HasSubstr("takes a host name"));
  }
  EXPECT_EQ(
      operator_.Fleetpub({"ping", "-b", secure, "--tls-server-name", "Broker.Example"}).exit_code,
      4);
  EXPECT_EQ(
      operator_.Fleetpub({"ping", "-b", "mqtt://127.0.0.1:1", "--tls-server-name", "x"}).exit_code,
      2)
      << "not encrypted";
}

// TLS 1.3 lets us speak before the broker has looked at our certificate.
TEST_F(TlsFailures, OfOurOwnCertificateNameTheCheck) {
  const auto& files = Certificates::Get();
  const Mosquitto broker(files.Subscription("server.crt", {"require_certificate true"}));
  const std::string url = broker.Url("mqtts", "localhost");
  // Often enough to see the broker's alert and its hanging up in either order.
  for (int i = 0; i < 5; ++i) {
    ExpectRefusal(broker, Pause(url, Showing("", "")), kNoCertificate);
    ExpectRefusal(broker, Pause(url, Showing("stranger.crt", "stranger.key")), kWrongCertificate);
  }
  EXPECT_EQ(Pause(url, Showing("client.crt", "client.key")).exit_code, 0);
  const Finished mismatch = Pause(url, Showing("client.crt", "server.key"));
  EXPECT_EQ(mismatch.exit_code, 2) << mismatch.errors;
  EXPECT_THAT(mismatch.errors, HasSubstr("--key"));
}

TEST_F(TlsFailures, OfOurOwnCertificateAreNamedInTls12) {
  const auto& files = Certificates::Get();
  const std::string port = std::to_string(FreePort());
  Process server({.arguments = {"openssl", "s_server", "-tls1_2", "-Verify", "1",
                                "-verify_return_error", "-CAfile", files / "ca.crt", "-accept",
                                port, "-cert", files / "server.crt", "-key", files / "server.key"},
                  .input = std::nullopt});
  ASSERT_TRUE(server.AwaitOutput("ACCEPT")) << server.Errors();
  const std::string url = "mqtts://localhost:" + port;
  EXPECT_THAT(Pause(url, Showing("", "")).errors, HasSubstr(kNoCertificate));
  EXPECT_THAT(Pause(url, Showing("stranger.crt", "stranger.key")).errors,
              HasSubstr(kWrongCertificate));
}

TEST_F(TlsFailures, OfSilenceEndInTime) {
  const BrokenBroker silent(BrokenBroker::Silent());
  for (const char* scheme : {"mqtts", "wss"}) {
    const Finished run = operator_.Fleetpub(
        {"pause", "KIT/0001", "-b", silent.Url(scheme), "--connect-timeout", "3s"});
    EXPECT_EQ(run.exit_code, 4);
    EXPECT_THAT(run.errors, ::testing::ContainsRegex("gave no TLS answer within [0-9.]+ m?s:"));
  }
}

}  // namespace
}  // namespace fleetpub::testing
