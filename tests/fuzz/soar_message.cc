// A SoAR message: a line with its topic, then the JSON. As an acknowledgement, and against each
// schema.
#include "base/json.h"
#include "fuzz/fuzz.h"
#include "schema/schema.h"
#include "soar/acknowledgement_tracker.h"
#include "soar/message.h"

using namespace fleetpub;

FUZZ(text) {
  static schema::Registry registry;
  static const auto schema = registry.Find(soar::kMessageSchema);
  const auto [topic, payload] = fuzz::Cut(text, '\n');
  const auto document = base::ParseJsonLeniently(payload);
  if (!document) return;
  const auto acknowledgement = soar::ReadAcknowledgement(topic, *document, {});
  if (acknowledgement) {
    auto tracker =
        soar::TrackAcknowledgements({.message_id = acknowledgement->message_id, .topics = {"#"}});
    tracker->Published(0);
    tracker->Receive({topic, payload});
    fuzz::Require(tracker->progress().seen);
  }
  static_cast<void>((*schema)->Validate(*document));
}
