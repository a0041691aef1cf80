#include "cli/main.h"

int main(int argc, char** argv) {
  return fleetpub::cli::Main(argc, argv, {FLEETPUB_VERSION, FLEETPUB_BUILD});
}
