#include "dispatch/collect.h"

#include <algorithm>

namespace fleetpub::dispatch {

Result<std::vector<mqtt::Message>> Collect(mqtt::Transport& transport,
                                           std::span<const std::string> filters,
                                           const CollectOptions& options, const Enough& enough) {
  using std::chrono::steady_clock;
  const auto limit = steady_clock::now() + options.most;
  constexpr std::chrono::seconds kPatience{10};
  auto subscribed =
      transport.Subscribe(filters, mqtt::kListeningQos, steady_clock::now() + kPatience);
  if (!subscribed) return Fail(std::move(subscribed.error()));
  std::vector<mqtt::Message> messages;
  while (!enough(messages)) {
    auto message = transport.Receive(std::min(limit, steady_clock::now() + options.quiet));
    if (!message) return Fail(std::move(message.error()));
    if (!*message) break;
    messages.push_back(std::move(**message));
  }
  return messages;
}

}  // namespace fleetpub::dispatch
