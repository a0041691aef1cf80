// C: the topic `connection`.
#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "app/conformance/case.h"
#include "base/text.h"

namespace fleetpub::app::conformance {
namespace {

using vda5050::Version;

CaseFinding CheckRetained(Run& run) {
  constexpr seconds kPatience{2};
  const auto found = run.Of("connection");
  for (const Heard* one : found) {
    if (one->message.retained && one->at <= run.began() + kPatience) {
      return Pass("it was there on subscribing", {one->Evidence()});
    }
  }
  if (!found.empty()) return Fault("it comes, but is not retained", {found.front()->Evidence()});
  if (run.last_state() == nullptr) return Inconclusive("the robot was not heard at all");
  return Fault("the robot sends states, and has left no connection message",
               {run.last_state()->Evidence()});
}

// A broker hands it out at the QoS with which it came, at most that of the subscription.
CaseFinding CheckQos(Run& run) {
  const auto found = run.Of("connection");
  if (found.empty()) return Inconclusive("no connection message came");
  for (const Heard* one : found) {
    if (one->message.qos == mqtt::Qos::kAtMostOnce) {
      return Fault("it came with QoS 0", {one->Evidence()});
    }
  }
  return Pass("it came with QoS 1", {found.front()->Evidence()});
}

CaseFinding CheckWords(Run& run) {
  constexpr auto kUpTo21 =
      std::to_array<std::string_view>({"ONLINE", "OFFLINE", "CONNECTIONBROKEN"});
  constexpr auto kFrom30 =
      std::to_array<std::string_view>({"ONLINE", "OFFLINE", "HIBERNATING", "CONNECTION_BROKEN"});
  const auto is_known = [&](std::string_view word) {
    return run.Is30() ? std::find(kFrom30.begin(), kFrom30.end(), word) != kFrom30.end()
                      : std::find(kUpTo21.begin(), kUpTo21.end(), word) != kUpTo21.end();
  };
  const auto found = run.Of("connection");
  if (found.empty()) return Inconclusive("no connection message came");
  for (const Heard* one : found) {
    const auto word = base::StringMember(one->json, "connectionState");
    if (!is_known(word)) {
      return Fault(fmt::format("connectionState is \"{}\"", vda5050::Shown(word)),
                   {one->Evidence()});
    }
  }
  return Pass("it says so", {found.front()->Evidence()});
}

using enum Version;
constexpr auto kConnectionCases = std::to_array<Case>({
    {"C01", Level::kListen, k110, k300, "6.5 / 6.14", "connection is retained", "2 s",
     "publish connection with the retain flag, at every connect", CheckRetained},
    {"C02", Level::kListen, k200, k300, "4.1 / 6.2", "connection is published with QoS 1", "",
     "publish connection, and set its last will, with QoS 1", CheckQos},
    {"C03", Level::kListen, k110, k300, "6.5 / 6.14", "after a lost connection ONLINE comes again",
     "60 s", "publish ONLINE after every connect, not the first one only", nullptr},
    {"C04", Level::kListen, k110, k300, "6.5 / 6.14",
     "a cut cable makes the last will appear, retained", "1.5 keep-alives",
     "set a retained last will with the word of the version, and a short keep-alive", nullptr},
    {"C05", Level::kListen, k110, k300, "6.5 / 6.14",
     "an orderly stop says OFFLINE, then disconnects", "",
     "publish OFFLINE before DISCONNECT, so that no last will appears", nullptr},
    {"C06", Level::kListen, k110, k300, "7.7 / 6.14",
     "connectionState is one of the version's words", "",
     "3.0 writes CONNECTION_BROKEN, what came before it CONNECTIONBROKEN", CheckWords},
});

}  // namespace

std::span<const Case> ConnectionCases() { return kConnectionCases; }

}  // namespace fleetpub::app::conformance
