// What the use cases work with, besides their requests.
#pragma once

#include <functional>
#include <memory>

#include "base/result.h"
#include "ledger/ledger.h"
#include "ledger/options.h"

namespace fleetpub::app {

/// Opens the ledger. Errors: ErrorKind::kUsage, kLedger.
using LedgerHook = std::function<Result<std::unique_ptr<ledger::Ledger>>(ledger::OpenMode mode)>;

}  // namespace fleetpub::app
