#include "mqtt/paho/paho_properties.h"

#include <new>
#include <string>

namespace fleetpub::mqtt {
namespace {

// Paho copies it, but takes it as char*.
MQTTLenString Text(const std::string& text) {
  return {static_cast<int>(text.size()), const_cast<char*>(text.data())};
}

void Add(MQTTProperties& list, const MQTTProperty& property) {
  if (MQTTProperties_add(&list, &property) != 0) throw std::bad_alloc();
}

}  // namespace

PahoProperties::PahoProperties(const PublishProperties& properties) {
  if (properties.expiry) {
    MQTTProperty expiry{};
    expiry.identifier = MQTTPROPERTY_CODE_MESSAGE_EXPIRY_INTERVAL;
    expiry.value.integer4 = static_cast<unsigned int>(properties.expiry->count());
    Add(list_, expiry);
  }
  for (const auto& [name, value] : properties.user) {
    MQTTProperty user{};
    user.identifier = MQTTPROPERTY_CODE_USER_PROPERTY;
    user.value.data = Text(name);
    user.value.value = Text(value);
    Add(list_, user);
  }
}

PahoProperties::~PahoProperties() { MQTTProperties_free(&list_); }

}  // namespace fleetpub::mqtt
