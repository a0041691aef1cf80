// Certificates and keys in files.
#pragma once

#include <string>

#include "base/result.h"
#include "mqtt/transport.h"

namespace fleetpub::mqtt {

/// What is wrong with the files that a person named, since Paho's word for it is "-1". Errors:
/// ErrorKind::kUsage.
[[nodiscard]] Status CheckTlsFiles(const TlsOptions& options);

/// The system's trust store when OpenSSL's own default is not on this machine (a static binary on
/// another distribution); else "".
[[nodiscard]] std::string FindTrustStore();

}  // namespace fleetpub::mqtt
