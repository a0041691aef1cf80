// A line of a recording, whoever wrote it. What is read of it can be written, and is read as the same.
#include "base/text.h"
#include "fuzz/fuzz.h"
#include "recording/entry.h"

using namespace fleetpub;

FUZZ(text) {
  static_cast<void>(recording::IsOpenRow(text));
  const auto check = [](const recording::Message& message) {
    const auto again = recording::ParseJsonLine(recording::ToLine(message), {});
    fuzz::Require(again && *again);
    const auto* read = std::get_if<recording::Message>(&**again);
    fuzz::Require(read != nullptr && read->payload == message.payload);
    fuzz::Require(read->qos == message.qos && read->retain == message.retain);
    if (base::IsUtf8(message.topic)) fuzz::Require(read->topic == message.topic);
  };
  if (const auto row = recording::ParseCsvRow(text)) check(*row);
  const auto entry = recording::ParseJsonLine(text, {});
  if (!entry) {
    fuzz::Require(!entry.error().message.empty());
    return;
  }
  if (!*entry) return;
  if (const auto* message = std::get_if<recording::Message>(&**entry)) {
    check(*message);
  } else {
    std::visit([](const auto& one) { fuzz::Require(recording::ToLine(one).ends_with("}\n")); },
               **entry);
  }
}
