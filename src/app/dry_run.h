// What would be sent, with the header ids that would be next.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>

#include "app/environment.h"
#include "base/result.h"
#include "delivery/send_all.h"
#include "message/command.h"
#include "message/report.h"

namespace fleetpub::app {

class DryRun {
 public:
  /// Reads the ledger, if there is one.
  [[nodiscard]] static Result<DryRun> Open(const LedgerHook& open);

  /// As of now; the topic's next command would get the id behind this one's. Errors:
  /// ErrorKind::kUsage (an id asked for that is not above the last one), kLedger.
  [[nodiscard]] Result<message::Report> Report(const message::Command& command);

 private:
  explicit DryRun(std::unique_ptr<ledger::Ledger> ledger);
  [[nodiscard]] Result<std::uint32_t> NextId(const message::Command& command);

  std::unique_ptr<ledger::Ledger> ledger_;
  std::map<std::string, std::uint32_t> last_ids_;  // by topic
};

/// Reports what would be sent of all that the source makes; `explain`, which may be empty, is called
/// behind each with its place among those that the source made last. Errors: as DryRun's, and the
/// source's.
[[nodiscard]] Status ShowDryRun(delivery::CommandSource& source, const Environment& environment,
                                Observer& observer,
                                const std::function<void(std::size_t)>& explain = {});

}  // namespace fleetpub::app
