#include "mqtt/certificate_check.h"

#include <arpa/inet.h>
#include <openssl/x509_vfy.h>
#include <openssl/x509v3.h>

#include <array>
#include <memory>
#include <vector>

#include "base/text.h"

namespace fleetpub::mqtt {
namespace {

constexpr std::size_t kMostNames = 5;  // in a sentence

std::string FormatText(const ASN1_STRING* text) {
  return {reinterpret_cast<const char*>(ASN1_STRING_get0_data(text)),
          static_cast<std::size_t>(ASN1_STRING_length(text))};
}

std::string AddressText(const std::string& bytes) {
  std::array<char, INET6_ADDRSTRLEN> text{};
  const int family = bytes.size() == sizeof(in_addr) ? AF_INET : AF_INET6;
  const bool has_size = family == AF_INET || bytes.size() == sizeof(in6_addr);
  return has_size && inet_ntop(family, bytes.data(), text.data(), text.size()) != nullptr
             ? text.data()
             : "";
}

bool HasAlternativeNames(const X509* certificate) {
  return X509_get_ext_by_NID(certificate, NID_subject_alt_name, -1) >= 0;
}

std::string SubjectName(const X509* certificate) {
  const X509_NAME* const subject = X509_get_subject_name(certificate);
  const int at = X509_NAME_get_index_by_NID(subject, NID_commonName, -1);
  return at < 0 ? "" : FormatText(X509_NAME_ENTRY_get_data(X509_NAME_get_entry(subject, at)));
}

std::string FormatNames(const X509* certificate) {
  if (!HasAlternativeNames(certificate)) return SubjectName(certificate);
  const std::unique_ptr<GENERAL_NAMES, decltype(&GENERAL_NAMES_free)> names(
      static_cast<GENERAL_NAMES*>(
          X509_get_ext_d2i(certificate, NID_subject_alt_name, nullptr, nullptr)),
      GENERAL_NAMES_free);
  std::vector<std::string> found;
  for (int i = 0; names != nullptr && i < sk_GENERAL_NAME_num(names.get()); ++i) {
    const GENERAL_NAME* const name = sk_GENERAL_NAME_value(names.get(), i);
    if (found.size() == kMostNames) break;
    if (name->type == GEN_DNS) found.push_back(FormatText(name->d.dNSName));
    if (name->type == GEN_IPADD) found.push_back(AddressText(FormatText(name->d.iPAddress)));
  }
  return base::Join(found, ", ");
}

// What X509_verify_cert() is to hold the certificate against.
bool Demand(X509_VERIFY_PARAM* demands, const X509* certificate, const std::string& host) {
  unsigned flags = X509_CHECK_FLAG_NO_PARTIAL_WILDCARDS;
  if (HasAlternativeNames(certificate)) flags |= X509_CHECK_FLAG_NEVER_CHECK_SUBJECT;
  X509_VERIFY_PARAM_set_hostflags(demands, flags);
  if (X509_VERIFY_PARAM_set_purpose(demands, X509_PURPOSE_SSL_SERVER) != 1) return false;
  if (const std::string address = AddressBytes(host); !address.empty()) {
    return X509_VERIFY_PARAM_set1_ip(demands,
                                     reinterpret_cast<const unsigned char*>(address.data()),
                                     address.size()) == 1;
  }
  return X509_VERIFY_PARAM_set1_host(demands, host.data(), host.size()) == 1;
}

}  // namespace

std::string AddressBytes(const std::string& host) {
  const auto bytes = [](const auto& address) {
    return std::string(reinterpret_cast<const char*>(&address), sizeof address);
  };
  in_addr v4{};
  if (inet_aton(host.c_str(), &v4) != 0) return bytes(v4);  // 127.1 as well, like getaddrinfo()
  in6_addr v6{};
  const std::string without_zone = host.substr(0, host.find('%'));
  return inet_pton(AF_INET6, without_zone.c_str(), &v6) == 1 ? bytes(v6) : "";
}

CertificateVerdict VerifyCertificate(x509_store_ctx_st* store, const std::string& host) {
  X509* const certificate = X509_STORE_CTX_get0_cert(store);
  if (certificate == nullptr || !Demand(X509_STORE_CTX_get0_param(store), certificate, host)) {
    X509_STORE_CTX_set_error(store, X509_V_ERR_UNSPECIFIED);
  } else if (X509_verify_cert(store) != 1) {
    if (X509_STORE_CTX_get_error(store) == X509_V_OK) {
      X509_STORE_CTX_set_error(store, X509_V_ERR_UNSPECIFIED);
    }
  } else if ((X509_get_extended_key_usage(certificate) & XKU_SSL_SERVER) == 0) {
    X509_STORE_CTX_set_error(store, X509_V_ERR_INVALID_PURPOSE);  // OpenSSL takes Netscape's too
  }
  const int code = X509_STORE_CTX_get_error(store);
  return {code, code == X509_V_OK || certificate == nullptr ? "" : FormatNames(certificate)};
}

}  // namespace fleetpub::mqtt
