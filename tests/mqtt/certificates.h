// A certificate authority of the test's own, by the openssl program.
#pragma once

#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "support/process.h"
#include "support/temporary_folder.h"

namespace fleetpub::mqtt {

/// Made once per test program, since making keys takes time; removed at its end.
class Certificates {
 public:
  static const Certificates& Get();

  /// The path of one of: ca.crt; server.crt and server.key (for localhost and 127.0.0.1); other.crt
  /// (for other.example, with server.key); expired.crt, self.crt (with server.key, the latter
  /// signed by itself); client.crt and client.key, whose password is "secret"; stranger.crt and
  /// stranger.key (another authority).
  [[nodiscard]] std::string operator/(const std::string& name) const {
    return (folder_ / name).string();
  }

  /// NAME.crt, with server.key: the authority's certificate with these lines of extensions, such as
  /// "subjectAltName=DNS:a.example".
  void Make(const std::string& name, const std::string& subject,
            const std::string& extensions) const {
    Sign(name, "server.key", extensions, "30", subject);
  }

  /// mosquitto's lines for a listener with this certificate.
  [[nodiscard]] std::vector<std::string> Subscription(const std::string& certificate = "server.crt",
                                                      std::vector<std::string> more = {}) const;

 private:
  Certificates();
  void Openssl(std::vector<std::string> arguments) const;
  void Sign(const std::string& name, const std::string& key, const std::string& extensions,
            const std::string& days, const std::string& subject = {}) const;

  fleetpub::testing::TemporaryFolder folder_;
};

inline const Certificates& Certificates::Get() {
  static const Certificates certificates;
  return certificates;
}

inline Certificates::Certificates() {
  for (const std::string name : {"ca", "stranger"}) {
    Openssl({"req", "-x509", "-newkey", "rsa:2048", "-nodes", "-days", "30", "-subj", "/CN=" + name,
             "-keyout", name + ".key", "-out", name + ".crt"});
  }
  Openssl({"genrsa", "-out", "server.key", "2048"});
  Openssl({"genrsa", "-aes128", "-passout", "pass:secret", "-out", "client.key", "2048"});
  const std::string here = "subjectAltName=DNS:localhost,IP:127.0.0.1";
  Sign("server", "server.key", here, "30");
  Sign("other", "server.key", "subjectAltName=DNS:other.example", "30");
  Sign("expired", "server.key", here, "-1");
  Openssl({"req", "-x509", "-key", "server.key", "-days", "30", "-subj", "/CN=localhost", "-addext",
           here, "-out", "self.crt"});
  Sign("client", "client.key", "extendedKeyUsage=clientAuth", "30");
}

inline void Certificates::Openssl(std::vector<std::string> arguments) const {
  arguments.insert(arguments.begin(), "openssl");
  const auto made = fleetpub::testing::Run(
      {.arguments = std::move(arguments), .folder = folder_.path().string()});
  if (made.exit_code != 0) throw std::runtime_error("openssl: " + made.errors);
}

inline void Certificates::Sign(const std::string& name, const std::string& key,
                               const std::string& extensions, const std::string& days,
                               const std::string& subject) const {
  folder_.Write(name + ".ext", extensions);
  Openssl({"req", "-new", "-key", key, "-passin", "pass:secret", "-subj",
           "/CN=" + (subject.empty() ? name : subject), "-out", name + ".csr"});
  Openssl({"x509", "-req", "-in", name + ".csr", "-CA", "ca.crt", "-CAkey", "ca.key",
           "-CAcreateserial", "-days", days, "-extfile", name + ".ext", "-out", name + ".crt"});
}

inline std::vector<std::string> Certificates::Subscription(const std::string& certificate,
                                                           std::vector<std::string> more) const {
  more.insert(more.end(), {"allow_anonymous true", "cafile " + *this / "ca.crt",
                           "certfile " + *this / certificate, "keyfile " + *this / "server.key"});
  return more;
}

}  // namespace fleetpub::mqtt
