#include "mqtt/tls_files.h"

#include <fmt/format.h>
#include <openssl/err.h>
#include <openssl/ssl.h>
#include <openssl/x509.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <memory>
#include <system_error>

#include "base/text.h"

namespace fleetpub::mqtt {
namespace {

// Debian, Fedora, openSUSE, Alpine and the BSDs.
constexpr std::array<const char*, 4> kTrustStores{"/etc/ssl/certs/ca-certificates.crt",
                                                  "/etc/pki/tls/certs/ca-bundle.crt",
                                                  "/etc/ssl/ca-bundle.pem", "/etc/ssl/cert.pem"};

std::string OpensslSays() {
  const unsigned long code = ERR_peek_last_error();
  ERR_clear_error();
  const char* const reason = ERR_reason_error_string(code);
  return reason == nullptr ? "" : reason;
}

Status CheckReadable(const std::string& path, std::string_view option) {
  if (path.empty() || access(path.c_str(), R_OK) == 0) return {};
  return Fail(ErrorKind::kUsage,
              fmt::format("cannot read {} ({}): {}", base::Printable(path), option,
                          base::ToLower(std::generic_category().message(errno))));
}

int GivePassword(char* buffer, int size, int /*writing*/, void* password) {
  const auto& text = *static_cast<const std::string*>(password);
  if (text.size() > static_cast<std::size_t>(size)) return -1;
  std::copy(text.begin(), text.end(), buffer);  // OpenSSL wants no NUL
  return static_cast<int>(text.size());
}

Status CheckContents(const TlsOptions& options) {
  const std::unique_ptr<SSL_CTX, decltype(&SSL_CTX_free)> context(SSL_CTX_new(TLS_client_method()),
                                                                  SSL_CTX_free);
  if (context == nullptr) return {};
  const auto bad = [](const std::string& path, std::string_view what, std::string_view option) {
    return Fail(ErrorKind::kUsage, fmt::format("{} ({}) {}", base::Printable(path), option, what),
                OpensslSays());
  };
  if (!options.ca_file.empty() &&
      SSL_CTX_load_verify_locations(context.get(), options.ca_file.c_str(), nullptr) != 1) {
    return bad(options.ca_file, "holds no certificate in PEM form", "--cafile");
  }
  if (!options.ciphers.empty() &&
      SSL_CTX_set_cipher_list(context.get(), options.ciphers.c_str()) != 1) {
    return bad(options.ciphers, "names no cipher that OpenSSL knows", "--ciphers");
  }
  if (options.cert_file.empty()) return {};
  if (SSL_CTX_use_certificate_chain_file(context.get(), options.cert_file.c_str()) != 1) {
    return bad(options.cert_file, "holds no certificate in PEM form", "--cert");
  }
  const std::string& key = options.key_file.empty() ? options.cert_file : options.key_file;
  std::string password = options.key_password.value_or("");
  SSL_CTX_set_default_passwd_cb(context.get(), GivePassword);
  SSL_CTX_set_default_passwd_cb_userdata(context.get(), &password);
  if (SSL_CTX_use_PrivateKey_file(context.get(), key.c_str(), SSL_FILETYPE_PEM) != 1) {
    return bad(
        key,
        "holds no private key that fits the certificate and the password (--key-password-file)",
        "--key");
  }
  return {};
}

}  // namespace

Status CheckTlsFiles(const TlsOptions& options) {
  for (const auto& [path, option] :
       {std::pair<const std::string&, std::string_view>{options.ca_file, "--cafile"},
        {options.ca_path, "--capath"},
        {options.cert_file, "--cert"},
        {options.key_file, "--key"}}) {
    if (auto status = CheckReadable(path, option); !status) return status;
  }
  return CheckContents(options);
}

std::string FindTrustStore() {
  if (getenv(X509_get_default_cert_file_env()) != nullptr ||
      getenv(X509_get_default_cert_dir_env()) != nullptr ||
      access(X509_get_default_cert_file(), R_OK) == 0 ||
      access(X509_get_default_cert_dir(), R_OK) == 0) {
    return {};
  }
  for (const char* const path : kTrustStores) {
    if (access(path, R_OK) == 0) return path;
  }
  return {};
}

}  // namespace fleetpub::mqtt
