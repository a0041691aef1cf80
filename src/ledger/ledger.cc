#include "ledger/ledger.h"

namespace fleetpub::ledger {

std::string BuildPayload(const Draft& draft, std::uint32_t header_id) {
  if (!draft.counted) return draft.before_id;
  return draft.before_id + std::to_string(header_id) + draft.after_id;
}

}  // namespace fleetpub::ledger
