// Reads one configuration file strictly: what is not understood is refused with its place, since a
// misspelt key would otherwise be a setting that silently does not hold.
#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>

#include "base/text.h"
#include "config/config.h"
#include "config/config_files.h"
#include "config/config_settings.h"
#include "config/toml_text.h"

namespace fleetpub::config {
namespace {

using Type = TomlValue::Type;

constexpr std::string_view kAllowInsecure = "allow_insecure";
constexpr std::string_view kPasswordFile = "password_file";

std::string_view GetName(Type type) {
  switch (type) {
    case Type::kText:
      return "a text";
    case Type::kInteger:
    case Type::kNumber:
      return "a number";
    case Type::kBoolean:
      return "true or false";
    case Type::kTime:
      return "a date or time";
    case Type::kArray:
      return "a list";
    case Type::kTable:
      return "a table";
  }
  return "something else";
}

std::string_view Wanted(SettingType type) {
  switch (type) {
    case SettingType::kText:
    case SettingType::kPath:
      return "a text in quotation marks";
    case SettingType::kTexts:
      return "a text in quotation marks or a list of such";
    case SettingType::kCommand:
      return R"(a list of texts, the program first: ["pass", "show", "fleet"])";
    case SettingType::kFlag:
      return "true or false";
    case SettingType::kWhole:
      return "a whole number";
    case SettingType::kTextOrWhole:
      return "a text in quotation marks or a whole number";
  }
  return "something else";
}

bool IsListOfTexts(const TomlValue& value) {
  return value.type == Type::kArray && !value.items.empty() &&
         std::all_of(value.items.begin(), value.items.end(),
                     [](const TomlValue& item) { return item.type == Type::kText; });
}

bool HasType(SettingType type, const TomlValue& value) {
  switch (type) {
    case SettingType::kText:
    case SettingType::kPath:
      return value.type == Type::kText;
    case SettingType::kTexts:
      return value.type == Type::kText || IsListOfTexts(value);
    case SettingType::kCommand:
      return IsListOfTexts(value) && !value.items.front().text.empty();
    case SettingType::kFlag:
      return value.type == Type::kBoolean;
    case SettingType::kWhole:
      return value.type == Type::kInteger;
    case SettingType::kTextOrWhole:
      return value.type == Type::kText || value.type == Type::kInteger;
  }
  return false;
}

bool IsSecret(std::string_view key) {
  return key == "password" || key == "key_password" || key == "passwd" || key == "pass";
}

class Reader {
 public:
  Reader(const std::string& file, Config& config, Mistakes& mistakes, const ValueCheck& check)
      : file_(file), config_(config), mistakes_(mistakes), check_(check) {}

  void Read(const TomlValue& document) {
    ConfigSection own;
    for (const TomlMember& member : document.members) {
      if (member.name == "profile") {
        EachTable(member, [&](const TomlMember& m) { ReadProfile(m); });
      } else if (member.name == "robot") {
        EachTable(member, [&](const TomlMember& m) { ReadRobot(m); });
      } else if (member.name == "group") {
        ReadGroups(member);
      } else if (member.name == "default_profile") {
        Note(ReadDefaultProfile(member));
      } else {
        Note(ReadSetting(member, Settings(),
                         {kAllowInsecure, "default_profile", "profile", "robot", "group"}, "",
                         own));
      }
    }
    Check(own);
    Lay(std::move(own), config_.settings);
  }

 private:
  void Note(Status status) {
    if (!status) mistakes_.push_back(std::move(status.error()));
  }

  [[nodiscard]] ConfigPlace At(TomlPlace place) const { return {file_, place.line, place.column}; }

  // A later file's keys go before an earlier one's; of the ways to a password it is one key.
  static void Lay(ConfigSection over, ConfigSection& section) {
    over.erase(std::string(kAllowInsecure));
    for (const auto& [key, other] :
         {std::pair(kPasswordFile, kPasswordCommand), std::pair(kPasswordCommand, kPasswordFile)}) {
      if (over.contains(key)) section.erase(std::string(other));
    }
    for (auto& [key, value] : over) section.insert_or_assign(key, std::move(value));
  }

  template <typename Function>
  void EachTable(const TomlMember& tables, const Function& read) {
    if (tables.value.type != Type::kTable) {
      mistakes_.push_back(ErrorAt(At(tables.place),
                                  fmt::format("{0} holds tables: write [{0}.NAME]", tables.name)));
      return;
    }
    for (const TomlMember& member : tables.value.members) {
      if (member.value.type == Type::kTable) {
        read(member);
        continue;
      }
      mistakes_.push_back(
          ErrorAt(At(member.place), fmt::format("{0}.{1} is a table: write [{0}.{1}]", tables.name,
                                                base::Printable(member.name))));
    }
  }

  Status ReadSetting(const TomlMember& member, std::span<const Setting> known,
                     std::vector<std::string_view> further, const std::string& profile,
                     ConfigSection& section) {
    const auto refuse = [&](std::string_view why) {
      return Fail(
          ErrorAt(At(member.place), fmt::format("{}: {}", base::Printable(member.name), why)));
    };
    if (member.name == kAllowInsecure && !further.empty()) {
      if (!HasType(SettingType::kFlag, member.value)) return refuse("takes true or false");
      section[member.name] = {{member.value.text}, At(member.place), profile};
      return {};
    }
    const auto setting = std::find_if(known.begin(), known.end(),
                                      [&](const Setting& s) { return s.key == member.name; });
    if (setting == known.end()) {
      if (IsSecret(member.name)) {
        return refuse(
            "a configuration file holds no password: put it into a file of its own "
            "(chmod 600) and name that as password_file or key_password_file, or name a program "
            "that prints it as password_command");
      }
      for (const Setting& s : known) further.push_back(s.key);
      std::string name = member.name;
      std::replace(name.begin(), name.end(), '-', '_');
      const auto nearest = base::Nearest(name, further);
      return refuse(nearest ? fmt::format("there is no such key: did you mean {}?", *nearest)
                            : "there is no such key: fleetpub config init --stdout lists them");
    }
    if (!HasType(setting->type, member.value)) {
      return refuse(fmt::format("takes {}, not {}", Wanted(setting->type),
                                member.value.items.empty() && member.value.type == Type::kArray
                                    ? "an empty list"
                                    : GetName(member.value.type)));
    }
    return Store(member, *setting, profile, section);
  }

  Status Store(const TomlMember& member, const Setting& setting, const std::string& profile,
               ConfigSection& section) {
    ConfigValue value{{}, At(member.place), profile};
    const auto add = [&](const TomlValue& item) -> Status {
      if (setting.check != nullptr) {
        if (auto ok = setting.check(item.text); !ok) {
          return Fail(
              ErrorAt(At(item.place), fmt::format("{}: {}", setting.key, ok.error().message)));
        }
      }
      const bool is_program = setting.type == SettingType::kCommand && value.texts.empty() &&
                              item.text.find('/') != std::string::npos;
      value.texts.push_back(
          is_program || setting.type == SettingType::kPath ? ResolvePath(item.text) : item.text);
      return {};
    };
    if (member.value.type == Type::kArray) {
      for (const TomlValue& item : member.value.items) {
        if (auto ok = add(item); !ok) return ok;
      }
    } else if (auto ok = add(member.value); !ok) {
      return ok;
    }
    if (check_) {
      if (auto ok = check_(setting.key, value.texts); !ok) {
        return Fail(ErrorAt(value.place, ok.error().message));
      }
    }
    section[member.name] = std::move(value);
    return {};
  }

  // Relative to the file, so that it means the same from every folder.
  [[nodiscard]] std::string ResolvePath(const std::string& text) const {
    if (text.empty() || text.find("://") != std::string::npos) return text;
    if (text.starts_with("~/")) return (HomeFolder() / text.substr(2)).string();
    return (std::filesystem::path(file_).parent_path() / text).string();
  }

  void Check(const ConfigSection& section) {
    Note(CheckInsecure(section));
    const auto command = section.find(kPasswordCommand);
    if (command == section.end() || !section.contains(kPasswordFile)) return;
    Note(Fail(ErrorAt(command->second.place,
                      "password_command: this table has a password_file, too: keep one of them")));
  }

  static Status CheckInsecure(const ConfigSection& section) {
    const auto insecure = section.find("insecure");
    if (insecure == section.end() || insecure->second.texts.front() != "true") return {};
    const auto allowed = section.find(kAllowInsecure);
    if (allowed != section.end() && allowed->second.texts.front() == "true") return {};
    return Fail(ErrorAt(insecure->second.place,
                        "insecure = true lets anyone be the broker, for everybody who uses this "
                        "file: name the broker's authority as cafile, or write allow_insecure = "
                        "true beside it"));
  }

  Status ReadDefaultProfile(const TomlMember& member) {
    if (member.value.type != Type::kText) {
      return Fail(ErrorAt(At(member.place), "default_profile: takes a text in quotation marks"));
    }
    config_.default_profile = {{member.value.text}, At(member.place), {}};
    return {};
  }

  void ReadProfile(const TomlMember& table) {
    if (table.name.empty() || base::Printable(table.name) != table.name) {
      mistakes_.push_back(
          ErrorAt(At(table.place), "a profile's name is not empty and has no control character"));
      return;
    }
    ConfigSection own;
    for (const TomlMember& member : table.value.members) {
      Note(ReadSetting(member, Settings(), {kAllowInsecure}, table.name, own));
    }
    Check(own);
    Lay(std::move(own), config_.profiles[table.name]);
  }

  void ReadRobot(const TomlMember& table) {
    auto address = vda5050::ParseRobotAddress(table.name);
    if (!address) {
      mistakes_.push_back(ErrorAt(
          At(table.place),
          fmt::format("{}: write [robot.\"manufacturer/serialNumber\"]", address.error().message)));
      return;
    }
    ConfigSection own;
    for (const TomlMember& member : table.value.members) {
      Note(ReadSetting(member, RobotSettings(), {}, "", own));
    }
    ConfiguredRobot& robot = config_.robots[*address];
    robot.place = At(table.place);
    Lay(std::move(own), robot.settings);
  }

  void ReadGroups(const TomlMember& table) {
    if (table.value.type != Type::kTable) {
      mistakes_.push_back(ErrorAt(At(table.place),
                                  "group is a table: write [group], and below it NAME = "
                                  "[\"KIT/0001\", \"alias\"]"));
      return;
    }
    for (const TomlMember& member : table.value.members) Note(ReadGroup(member));
  }

  Status ReadGroup(const TomlMember& member) {
    if (auto ok = CheckTargetName(member.name); !ok) {
      return Fail(ErrorAt(At(member.place), ok.error().message));
    }
    if (member.value.type != Type::kArray || !HasType(SettingType::kTexts, member.value)) {
      return Fail(ErrorAt(At(member.place),
                          fmt::format("group {} takes a list of robots, at least one: [\"KIT/"
                                      "0001\", \"alias\"]",
                                      member.name)));
    }
    ConfiguredGroup group{At(member.place), {}};
    for (const TomlValue& item : member.value.items) {
      group.members.push_back({{item.text}, At(item.place), {}});
    }
    config_.groups.insert_or_assign(member.name, std::move(group));
    return {};
  }

  const std::string& file_;
  Config& config_;
  Mistakes& mistakes_;
  const ValueCheck& check_;
};

}  // namespace

void ReadConfig(std::string_view text, const std::string& file, Config& config, Mistakes& mistakes,
                const ValueCheck& check) {
  const auto document = ParseToml(text);
  if (!document) {
    mistakes.push_back({ErrorKind::kUsage,
                        fmt::format("{}:{}", base::Printable(file), document.error().message),
                        document.error().detail});
    return;
  }
  config.files.push_back(file);
  const std::size_t before = mistakes.size();
  Reader(file, config, mistakes, check).Read(*document);
  // As they stand in the file, not by name.
  const auto line = [&](const Error& error) {
    return std::atoi(error.message.c_str() + base::Printable(file).size() + 1);
  };
  std::stable_sort(mistakes.begin() + static_cast<std::ptrdiff_t>(before), mistakes.end(),
                   [&](const Error& a, const Error& b) { return line(a) < line(b); });
}

Status ReadConfig(std::string_view text, const std::string& file, Config& config) {
  Mistakes mistakes;
  ReadConfig(text, file, config, mistakes);
  if (mistakes.empty()) return {};
  return Fail(std::move(mistakes.front()));
}

}  // namespace fleetpub::config
