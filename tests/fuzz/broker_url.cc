// What names a broker.
#include "mqtt/broker_url.h"

#include "fuzz/fuzz.h"

using namespace fleetpub;

FUZZ(text) {
  const auto url = mqtt::ParseBrokerUrl(text);
  if (!url) {
    fuzz::Require(!url.error().message.empty());
    return;
  }
  auto again = mqtt::ParseBrokerUrl(url->ToString());
  if (again) again->username = url->username;  // the text never names the user
  fuzz::Require(again.has_value() && *again == *url);
}
