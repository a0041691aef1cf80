// A plugin that lets mosquitto take a token by MQTT 5's enhanced authentication (§4.12): the method
// TOKEN wants the data "sesame"; TWO-STEP asks for more, which AUTH packets would bring.
#include <mosquitto_broker.h>
#include <mosquitto_plugin.h>
#include <string.h>

// Of mosquitto.h, which another package has.
enum { kContinue = -4, kSuccess = 0, kNotSupported = 10, kRefused = 11 };

static int OnStart(int event, void* data, void* user_data) {
  static const char kToken[] = "sesame";
  struct mosquitto_evt_extended_auth* const start = data;
  (void)event;
  (void)user_data;
  if (strcmp(start->auth_method, "TWO-STEP") == 0) return kContinue;
  if (strcmp(start->auth_method, "TOKEN") != 0) return kNotSupported;
  const int is_right = start->data_in_len == strlen(kToken) && start->data_in != NULL &&
                       memcmp(start->data_in, kToken, strlen(kToken)) == 0;
  return is_right ? kSuccess : kRefused;
}

int mosquitto_plugin_version(int count, const int* versions) {
  for (int i = 0; i < count; ++i) {
    if (versions[i] == MOSQ_PLUGIN_VERSION) return MOSQ_PLUGIN_VERSION;
  }
  return -1;
}

int mosquitto_plugin_init(mosquitto_plugin_id_t* id, void** user_data,
                          struct mosquitto_opt* options, int count) {
  (void)user_data;
  (void)options;
  (void)count;
  return mosquitto_callback_register(id, MOSQ_EVT_EXT_AUTH_START, OnStart, NULL, NULL);
}

// It wants one.
int mosquitto_plugin_cleanup(void* user_data, struct mosquitto_opt* options, int count) {
  (void)user_data;
  (void)options;
  (void)count;
  return kSuccess;
}
