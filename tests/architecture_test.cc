// The dependency arrows of docs/architecture.md, read from the #includes of src:
//
//   main → cli → app → {config, simulator} → {vda5050, soar} → delivery → {schema, ledger, mqtt, recording} → message
//   → base
//
// A folder may include itself and any folder to its right, never one to its left nor its sibling in
// braces. Each third-party library has one folder that may see it.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <set>
#include <sstream>

namespace fleetpub {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

/// A source tree: path below src → content.
using Tree = std::map<std::string, std::string>;

struct Include {
  std::string file;    ///< who includes
  std::string header;  ///< what, without quotation marks or brackets
  bool quoted;
};

const std::map<std::string, int>& Ranks() {
  static const std::map<std::string, int> ranks = {
      {"main.cc", 0}, {"cli", 1},  {"app", 2},       {"simulator", 3}, {"config", 3},
      {"vda5050", 4}, {"soar", 4}, {"layout", 4},    {"delivery", 5},  {"schema", 6},
      {"ledger", 6},  {"mqtt", 6}, {"recording", 6}, {"message", 7},   {"base", 8}};
  return ranks;
}

struct Library {
  std::string_view header;   ///< how its headers begin
  std::string_view folders;  ///< the only ones that may include it
  bool in_headers = false;   ///< in headers too, as long as no other folder includes those
};

constexpr Library kLibraries[] = {
    {"openssl/evp.h", "mqtt recording"},
    {"zlib.h", "recording"},
    {"zstd.h", "recording"},
    {"MQTT", "mqtt", true},
    {"openssl/", "mqtt", true},
    {"sqlite3", "ledger"},
    {"SQLiteCpp/", "ledger"},
    {"libpq", "ledger"},
    {"re2/", "schema"},
    {"CLI/", "cli"},
    {"rapidjson/", "base", true},
    {"uuid/", "base"},
    {"toml++/", "config"},
};

// Of `base/json.h` it is `base`, of `main.cc` `main.cc`.
std::string GetFolder(const std::string& path) { return path.substr(0, path.find('/')); }

std::string ReadText(const std::filesystem::path& path) {
  std::ostringstream text;
  text << std::ifstream(path, std::ios::binary).rdbuf();
  return text.str();
}

Tree ReadTree(const std::filesystem::path& root) {
  Tree tree;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(root)) {
    const auto extension = entry.path().extension();
    if (extension != ".cc" && extension != ".h") continue;
    tree[entry.path().lexically_relative(root).string()] = ReadText(entry.path());
  }
  return tree;
}

std::vector<Include> ReadIncludes(const Tree& tree) {
  std::vector<Include> includes;
  for (const auto& [file, text] : tree) {
    std::istringstream lines(text);
    for (std::string line; std::getline(lines, line);) {
      line.erase(std::remove_if(line.begin(), line.end(), [](char c) { return c == ' '; }),
                 line.end());
      if (!line.starts_with("#include")) continue;
      const std::string header = line.substr(9, line.find_first_of("\">", 9) - 9);
      includes.push_back({file, header, line[8] == '"'});
    }
  }
  return includes;
}

std::string FaultOfArrow(const Include& include, const Tree& tree) {
  const std::string from = GetFolder(include.file);
  const std::string to = GetFolder(include.header);
  if (!tree.contains(include.header)) return "is not a path below src";
  if (!Ranks().contains(from) || !Ranks().contains(to)) return "concerns a folder without a place";
  if (from == to || Ranks().at(from) < Ranks().at(to)) return "";
  return Ranks().at(from) == Ranks().at(to) ? "points to a sibling" : "points upwards";
}

bool IsSeenOutside(const std::string& header, const std::vector<Include>& includes) {
  return std::any_of(includes.begin(), includes.end(), [&](const Include& include) {
    return include.header == header && GetFolder(include.file) != GetFolder(header);
  });
}

std::string FaultOfLibrary(const Include& include, const std::vector<Include>& includes) {
  for (const auto& [prefix, folders, in_headers] : kLibraries) {
    if (!include.header.starts_with(prefix)) continue;
    std::istringstream names{std::string(folders)};
    const std::set<std::string> may(std::istream_iterator<std::string>(names), {});
    if (!may.contains(GetFolder(include.file))) {
      return fmt::format("belongs into {} alone", folders);
    }
    if (include.file.ends_with(".cc") || prefix == "rapidjson/") return "";
    if (!in_headers) return "belongs into .cc files";
    if (IsSeenOutside(include.file, includes)) return "is seen by other folders";
  }
  return "";
}

// `cli/a.cc includes b/c.h, which …`, one per include that may not be.
std::vector<std::string> Faults(const Tree& tree) {
  const std::vector<Include> includes = ReadIncludes(tree);
  std::vector<std::string> faults;
  for (const Include& include : includes) {
    const std::string fault =
        include.quoted ? FaultOfArrow(include, tree) : FaultOfLibrary(include, includes);
    if (fault.empty()) continue;
    faults.push_back(fmt::format("{} includes {}, which {}", include.file, include.header, fault));
  }
  return faults;
}

const std::filesystem::path kRoot = FLEETPUB_SOURCE_DIR;

TEST(Architecture, HasNoArrowUpwardsOrSideways) {
  const Tree tree = ReadTree(kRoot / "src");
  ASSERT_GT(tree.size(), 50U);
  ASSERT_GT(ReadIncludes(tree).size(), 300U);
  EXPECT_THAT(Faults(tree), IsEmpty());
}

TEST(Architecture, HasAMainThatOnlyCallsTheCommandLine) {
  const Tree tree = ReadTree(kRoot / "src");
  for (const Include& include : ReadIncludes({{"main.cc", tree.at("main.cc")}})) {
    EXPECT_EQ(GetFolder(include.header), "cli");
  }
}

TEST(Architecture, ConfiguresRapidJsonInOnePlace) {
  for (const Include& include : ReadIncludes(ReadTree(kRoot / "src"))) {
    if (include.header != "rapidjson/document.h") continue;
    EXPECT_EQ(include.file, "base/rapidjson.h");
  }
}

TEST(Architecture, HasNoFileOfMoreThan600Lines) {
  for (const char* folder : {"src", "tests"}) {
    for (const auto& [file, text] : ReadTree(kRoot / folder)) {
      EXPECT_LE(std::count(text.begin(), text.end(), '\n'), 600) << folder << "/" << file;
    }
  }
}

TEST(Architecture, HasAGuardInEveryHeader) {
  for (const auto& [file, text] : ReadTree(kRoot / "src")) {
    if (!file.ends_with(".h")) continue;
    EXPECT_THAT(text, HasSubstr("#pragma once")) << file;
  }
}

TEST(ArchitectureCheck, SeesAnArrowThatMayNotBe) {
  const Tree tree = {
      {"base/a.h", "#include \"delivery/a.h\"\n"},
      {"cli/a.cc", "#include \"base/a.h\"\n#include \"mqtt/a.h\"\n#include \"../base/a.h\"\n"},
      {"delivery/a.h", "# include \"ledger/a.h\"\n#include \"vda5050/a.h\"\n"},
      {"ledger/a.h", ""},
      {"mqtt/a.h", "#include \"ledger/a.h\"\n#include \"mqtt/a.h\"\n"},
      {"vda5050/a.h", "// #include \"cli/a.cc\"\n"},
  };
  EXPECT_THAT(Faults(tree),
              ElementsAre("base/a.h includes delivery/a.h, which points upwards",
                          "cli/a.cc includes ../base/a.h, which is not a path below src",
                          "delivery/a.h includes vda5050/a.h, which points upwards",
                          "mqtt/a.h includes ledger/a.h, which points to a sibling"));
}

TEST(ArchitectureCheck, SeesALibraryThatMayNotBe) {
  const Tree tree = {
      {"cli/a.cc", "#include <CLI/CLI.hpp>\n#include <MQTTClient.h>\n#include \"mqtt/seen.h\"\n"},
      {"cli/b.h", "#include <CLI/CLI.hpp>\n"},
      {"delivery/a.cc", "#include <rapidjson/document.h>\n#include <vector>\n"},
      {"mqtt/private.h", "#include <MQTTClient.h>\n"},
      {"mqtt/seen.h", "#include <MQTTClient.h>\n"},
  };
  EXPECT_THAT(Faults(tree),
              ElementsAre("cli/a.cc includes MQTTClient.h, which belongs into mqtt alone",
                          "cli/b.h includes CLI/CLI.hpp, which belongs into .cc files",
                          "delivery/a.cc includes rapidjson/document.h, which belongs "
                          "into base alone",
                          "mqtt/seen.h includes MQTTClient.h, which is seen by other "
                          "folders"));
}

}  // namespace
}  // namespace fleetpub
