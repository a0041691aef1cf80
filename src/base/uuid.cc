#include "base/uuid.h"

#include <uuid/uuid.h>

#include <array>

namespace fleetpub::base {

std::string RandomUuid() {
  uuid_t id;
  uuid_generate_random(id);
  std::array<char, UUID_STR_LEN> text{};
  uuid_unparse_lower(id, text.data());
  return {text.data(), UUID_STR_LEN - 1};
}

}  // namespace fleetpub::base
