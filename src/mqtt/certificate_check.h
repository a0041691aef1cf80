// Whether a certificate is that of the broker that was asked for.
#pragma once

#include <string>

struct x509_store_ctx_st;

namespace fleetpub::mqtt {

struct CertificateVerdict {
  long code = 0;      ///< X509_V_ERR_…; 0: accepted
  std::string names;  ///< of a refused one: what it is for, `a.example, 192.0.2.7`; perhaps empty
};

/// The bytes of an IPv4 or IPv6 address in whatever form a URL may have it; empty: it is a name.
[[nodiscard]] std::string AddressBytes(const std::string& host);

/// In place of OpenSSL's own verification, with more demands: the purpose is serverAuth when the
/// certificate names any; its subject counts only when it has no alternative names at all (RFC 9525
/// §6.3 would not have it even then, but private authorities do); a host in numbers is among its IP
/// addresses; `*` stands for a whole label.
[[nodiscard]] CertificateVerdict VerifyCertificate(x509_store_ctx_st* store,
                                                   const std::string& host);

}  // namespace fleetpub::mqtt
