#include "dispatch/collect.h"

#include <algorithm>

namespace fleetpub::dispatch {

Status Collect(mqtt::Transport& transport, std::span<const std::string> filters,
               const CollectOptions& options, const Taker& take) {
  using std::chrono::steady_clock;
  auto ok = transport.Subscribe(filters, mqtt::kListeningQos,
                                steady_clock::now() + options.subscribe);
  if (!ok) return ok;
  // A broker may take long to grant a subscription; what it has retained follows then.
  const auto start = steady_clock::now();
  auto quiet_at = start + options.quiet;
  for (;;) {
    const auto message = transport.Receive(std::min(quiet_at, start + options.most));
    if (!message) return Fail(message.error());
    if (!*message || take(**message)) return {};
    if ((*message)->retained) quiet_at = steady_clock::now() + options.quiet;
    if (steady_clock::now() >= std::min(quiet_at, start + options.most)) return {};
  }
}

}  // namespace fleetpub::dispatch
