// What names a broker.
#include "mqtt/broker_url.h"

#include "fuzz.h"

using namespace fleetpub;

FUZZ(text) {
  const auto url = mqtt::ParseBrokerUrl(text);
  if (!url) {
    fuzz::Require(!url.error().message.empty());
    return;
  }
  const auto again = mqtt::ParseBrokerUrl(url->ToString());
  fuzz::Require(again.has_value() && *again == *url);
}
