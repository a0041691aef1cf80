// Certificates of brokers that must not hear a login, at real brokers.
#include "mqtt/certificate_check.h"

#include "mqtt/certificates.h"
#include "mqtt/connecting.h"
#include "support/mosquitto.h"

namespace fleetpub::mqtt {
namespace {

using fleetpub::testing::Mosquitto;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

struct Shown {
  std::string subject;  // its common name
  std::string extensions;
  std::string host = "localhost";
  std::string scheme = "mqtts";
};

void PrintTo(const Shown& shown, std::ostream* out) {
  *out << shown.scheme << "://" << shown.host << " as " << shown.subject << ": "
       << shown.extensions;
}

// A broker with such a certificate, and who wants to log in there.
class Broker {
 public:
  explicit Broker(const Shown& shown)
      : mosquitto_((
            Certificates::Get().Make("shown", shown.subject, shown.extensions),
            Certificates::Get().Subscription(
                "shown.crt", shown.scheme == "wss" ? std::vector<std::string>{"protocol websockets"}
                                                   : std::vector<std::string>()))),
        login_(To(mosquitto_.Url(shown.scheme, shown.host))) {
    login_.tls.ca_file = Certificates::Get() / "ca.crt";
    login_.username = "ann";
    login_.password = "hunter2";
  }

  [[nodiscard]] const ConnectOptions& login() const { return login_; }
  [[nodiscard]] std::string Log() const { return mosquitto_.Log(); }

 private:
  Mosquitto mosquitto_;
  ConnectOptions login_;
};

class WrongCertificate : public ::testing::TestWithParam<Shown> {};

TEST_P(WrongCertificate, HearsNoLogin) {
  const Broker broker(GetParam());
  const Error error = Refusal(broker.login());
  EXPECT_EQ(error.kind, ErrorKind::kBroker);
  EXPECT_THAT(error.message, HasSubstr("its certificate"));
  EXPECT_THAT(broker.Log(), Not(HasSubstr("New client connected")));
}

INSTANTIATE_TEST_SUITE_P(
    OfAnotherName, WrongCertificate,
    ::testing::Values(Shown{"localhost", "subjectAltName=DNS:other.example"},
                      Shown{"localhost", "subjectAltName=IP:127.0.0.1"},
                      Shown{"localhost", "subjectAltName=email:ann@plant.example"},
                      Shown{"localhost", "subjectAltName=URI:mqtts://localhost"},
                      Shown{"localhost", "subjectAltName=DNS:other.example", "localhost", "wss"},
                      Shown{"robot-7", "basicConstraints=CA:FALSE"},
                      Shown{"x", "subjectAltName=DNS:localhost.other.example"},
                      Shown{"x", "subjectAltName=DNS:loc*"}));

INSTANTIATE_TEST_SUITE_P(
    OfAnotherAddress, WrongCertificate,
    ::testing::Values(Shown{"x", "subjectAltName=DNS:127.0.0.1", "127.0.0.1"},
                      Shown{"127.0.0.1", "basicConstraints=CA:FALSE", "127.0.0.1"},
                      Shown{"127.0.0.1", "subjectAltName=DNS:localhost", "127.0.0.1"},
                      Shown{"x", "subjectAltName=IP:127.0.0.2,DNS:127.0.0.1", "127.0.0.1"},
                      Shown{"x", "subjectAltName=DNS:127.1", "127.1"},
                      Shown{"x", "subjectAltName=DNS:127.0.0.1", "127.0.0.1", "wss"}));

constexpr const char* kHere = "subjectAltName=DNS:localhost\n";
INSTANTIATE_TEST_SUITE_P(
    OfAnotherPurpose, WrongCertificate,
    ::testing::Values(Shown{"x", std::string(kHere) + "extendedKeyUsage=clientAuth"},
                      Shown{"x", std::string(kHere) + "extendedKeyUsage=codeSigning,timeStamping"},
                      Shown{"x", std::string(kHere) + "extendedKeyUsage=nsSGC"},
                      Shown{"x", std::string(kHere) + "extendedKeyUsage=anyExtendedKeyUsage"},
                      Shown{"x", std::string(kHere) + "keyUsage=critical,keyCertSign"}));

class RightCertificate : public ::testing::TestWithParam<Shown> {};

TEST_P(RightCertificate, IsBelieved) {
  const Broker broker(GetParam());
  const auto connection = ConnectPaho(broker.login());
  EXPECT_TRUE(connection) << connection.error().message << connection.error().detail;
}

INSTANTIATE_TEST_SUITE_P(
    Of, RightCertificate,
    ::testing::Values(Shown{"x", std::string(kHere) + "extendedKeyUsage=serverAuth"},
                      Shown{"x", std::string(kHere) + "extendedKeyUsage=clientAuth,serverAuth"},
                      Shown{"x", "subjectAltName=DNS:other.example,DNS:LOCALHOST"},
                      Shown{"x", "subjectAltName=IP:127.0.0.1", "127.0.0.1"},
                      Shown{"x", "subjectAltName=IP:127.0.0.1", "127.0.0.1", "wss"},
                      Shown{"localhost", "basicConstraints=CA:FALSE"}));

TEST(CertificateCheck, LooksAtNothingWhenToldSo) {
  const Broker broker({"x", "subjectAltName=DNS:other.example\nextendedKeyUsage=clientAuth"});
  ConnectOptions login = broker.login();
  login.tls.verify = false;
  EXPECT_TRUE(ConnectPaho(login));
}

TEST(CertificateCheck, SaysWhatIsWrong) {
  const auto told = [](const Shown& shown) { return Refusal(Broker(shown).login()).message; };
  EXPECT_THAT(told({"x", "subjectAltName=IP:192.0.2.7,DNS:a.example"}),
              HasSubstr("for 192.0.2.7, a.example, not for localhost"));
  EXPECT_THAT(told({"127.0.0.1", "basicConstraints=CA:FALSE", "127.0.0.1"}),
              HasSubstr("(IP:127.0.0.1)"));
  EXPECT_THAT(told({"x", std::string(kHere) + "extendedKeyUsage=clientAuth"}),
              HasSubstr("serverAuth"));
}

TEST(CertificateCheck, KnowsAddresses) {
  EXPECT_EQ(AddressBytes("192.0.2.7"), std::string("\xC0\0\2\7", 4));
  EXPECT_EQ(AddressBytes("127.1"), std::string("\x7F\0\0\1", 4));
  EXPECT_EQ(AddressBytes("::1"), std::string(15, '\0') + '\1');
  EXPECT_EQ(AddressBytes("fe80::1%eth0"), AddressBytes("fe80::1"));
  for (const char* name : {"localhost", "7.example", "", "a:b", "1.2.3.4.example"}) {
    EXPECT_THAT(AddressBytes(name), IsEmpty()) << name;
  }
}

// ── a list of brokers ──

TEST(CertificateCheck, EndsAList) {
  const Broker wrong({"x", "subjectAltName=DNS:other.example"});
  const Broker right({"x", kHere});
  ConnectOptions login = wrong.login();
  login.brokers.push_back(right.login().brokers.front());
  EXPECT_THAT(Refusal(login).message, HasSubstr("no other broker is tried"));
  EXPECT_THAT(right.Log(), Not(HasSubstr("New connection")));
  std::swap(login.brokers[0], login.brokers[1]);
  EXPECT_TRUE(ConnectPaho(login));
}

TEST(CertificateCheck, ALinkThatIsDownDoesNotEndAList) {
  const Broker right({"x", kHere});
  ConnectOptions login = right.login();
  login.brokers.insert(login.brokers.begin(), To("mqtts://127.0.0.1:1").brokers.front());
  EXPECT_TRUE(ConnectPaho(login));
}

TEST(CertificateCheck, AListIsAllEncryptedOrNotAtAll) {
  const Mosquitto plain;
  for (const std::string scheme : {"mqtts", "wss"}) {
    ConnectOptions login = To(scheme + "://127.0.0.1:1");
    login.brokers.push_back(To(plain.Url()).brokers.front());
    EXPECT_EQ(Refusal(login).kind, ErrorKind::kUsage);
    std::swap(login.brokers[0], login.brokers[1]);
    EXPECT_EQ(Refusal(login).kind, ErrorKind::kUsage);
  }
  EXPECT_THAT(plain.Log(), Not(HasSubstr("New connection")));
}

}  // namespace
}  // namespace fleetpub::mqtt
