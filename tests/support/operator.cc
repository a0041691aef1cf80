#include "support/operator.h"

#include <algorithm>
#include <cstdlib>
#include <sstream>
#include <thread>

#include "base/json.h"

namespace fleetpub::testing {

std::string Binary() {
  const char* other = std::getenv("FLEETPUB_BINARY");
  return other == nullptr ? FLEETPUB_BINARY : other;
}

std::vector<std::string> WithoutLook(std::vector<std::string> arguments) {
  const bool is_stated = std::find(arguments.begin(), arguments.end(), "--vda") != arguments.end();
  if (!is_stated) arguments.insert(arguments.end(), {"--vda", "3.0"});
  arguments.emplace_back("--no-check");
  return arguments;
}

Command Operator::Prepare(std::vector<std::string> arguments) const {
  arguments.insert(arguments.begin(), Binary());
  Command command{.arguments = std::move(arguments)};
  command.environment = {
      {"HOME", home_.path().string()},
      {"XDG_STATE_HOME", std::nullopt},
      {"XDG_CONFIG_HOME", std::nullopt},
      {"FLEETPUB_CONFIG", std::nullopt},
      {"FLEETPUB_PROFILE", std::nullopt},
      {"FLEETPUB_LEDGER", ledger_},
      {"FLEETPUB_VDA", std::nullopt},
      {"FLEETPUB_PASSWORD", std::nullopt},
      {"FLEETPUB_SOAR_PREFIX", std::nullopt},
      {"FLEETPUB_SOAR_SOURCE", std::nullopt},
      {"FLEETPUB_BROKER", broker_.empty() ? std::nullopt : std::optional(broker_)}};
  return command;
}

Finished Operator::Fleetpub(std::vector<std::string> arguments) const {
  return Run(Prepare(std::move(arguments)));
}

std::filesystem::path Operator::LedgerPath() const { return home_ / "ledger.db"; }

Subscriber::Subscriber(std::uint16_t port, const std::string& filter, int qos) {
  Command command{.arguments = {"stdbuf", "-oL", "mosquitto_sub", "-h", "127.0.0.1", "-p",
                                std::to_string(port), "-t", filter, "-q", std::to_string(qos), "-F",
                                "received %r %q %t %p", "-d"}};
  process_ = std::make_unique<Process>(std::move(command));
  if (!process_->AwaitOutput("SUBACK")) throw std::runtime_error("mosquitto_sub did not subscribe");
}

std::vector<Subscriber::Received> Subscriber::SoFar() const {
  std::vector<Received> messages;
  std::string output = process_->Output();
  output.resize(output.rfind('\n') + 1);  // the last line may still be growing
  for (const std::string& line : Lines(output)) {
    if (!line.starts_with("received ")) continue;
    Received message;
    std::istringstream words(line.substr(9));
    words >> message.retained >> message.qos >> message.topic;
    std::getline(words >> std::ws, message.payload);
    messages.push_back(std::move(message));
  }
  return messages;
}

std::vector<Subscriber::Received> Subscriber::Await(std::size_t count) const {
  const auto deadline = std::chrono::steady_clock::now() + Process::kPatience;
  std::vector<Received> messages = SoFar();
  while (messages.size() < count && std::chrono::steady_clock::now() < deadline) {
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
    messages = SoFar();
  }
  return messages;
}

base::JsonDocument Json(std::string_view text) {
  auto document = base::ParseJson(text);
  EXPECT_TRUE(document.has_value()) << text;
  return document ? std::move(*document) : base::JsonDocument();
}

std::vector<std::string> Lines(std::string_view text) {
  std::vector<std::string> lines;
  std::istringstream stream{std::string(text)};
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

void EndToEnd::Say(const std::string& topic, const std::string& payload, bool retained) const {
  Command command{.arguments = {"mosquitto_pub", "-h", "127.0.0.1", "-p",
                                std::to_string(broker_.port()), "-q", "1", "-s", "-t", topic},
                  .input = payload};
  if (retained) command.arguments.emplace_back("-r");
  EXPECT_EQ(testing::Run(std::move(command)).exit_code, 0);
}

std::unique_ptr<Process> EndToEnd::Robot(std::vector<std::string> arguments) const {
  arguments.insert(arguments.begin(), "simulate");
  auto robot = std::make_unique<Process>(operator_.Prepare(std::move(arguments)));
  EXPECT_TRUE(robot->AwaitErrors("online")) << robot->Errors();
  return robot;
}

}  // namespace fleetpub::testing
