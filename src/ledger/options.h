// How a ledger is opened, whatever keeps it.
#pragma once

#include <string>

namespace fleetpub::ledger {

/// Where the ids of a topic that the ledger does not know begin.
enum class HeaderIdStart {
  kZero,   ///< as the specification's examples do
  kEpoch,  ///< Unix seconds: still rises when the ledger was lost
};

struct Options {
  HeaderIdStart start = HeaderIdStart::kZero;
  bool keep_history = true;  ///< false: ids only
  std::string user;          ///< who commands, for the audit trail
  std::string host;
  std::string profile;
};

enum class OpenMode {
  /// Makes what is missing.
  kCreate,
  /// What is missing is an empty ledger and stays missing; nothing in an existing one is changed.
  /// Lock, Reserve, RecordOutcomes and Prune fail.
  kReadOnly,
};

}  // namespace fleetpub::ledger
