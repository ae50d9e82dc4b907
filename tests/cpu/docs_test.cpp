// README.md and docs: their links lead somewhere, and what they say of settings and of the
// library's use is what the code has.
#include <algorithm>
#include <cctype>
#include <filesystem>
#include <gtest/gtest.h>
#include <regex>
#include <set>
#include <sstream>

#include <fumarole/settings.h>

#include "support/temp_folder.h"

namespace fumarole {
namespace {

namespace fs = std::filesystem;

const fs::path kRoot = fs::path(FUM_TEST_DATA).parent_path();

std::vector<fs::path> pages()
{
    std::vector<fs::path> found{kRoot / "README.md", kRoot / "vdb_samples" / "README.md"};
    for (const auto& entry : fs::directory_iterator(kRoot / "docs"))
        if (entry.path().extension() == ".md")
            found.push_back(entry.path());
    return found;
}

/// Every match's first group.
std::vector<std::string> all_of(const std::string& text, const std::string& pattern)
{
    const std::regex regex(pattern);
    std::vector<std::string> found;
    for (std::sregex_iterator it(text.begin(), text.end(), regex), end; it != end; ++it)
        found.push_back((*it)[1]);
    return found;
}

/// A heading's name in a link: lower case, hyphens for spaces, no punctuation.
std::set<std::string> anchors_of(const fs::path& page)
{
    std::set<std::string> anchors;
    for (const std::string& heading : all_of(test::read_bytes(page), "\n#+ ([^\n]*)")) {
        std::string anchor;
        for (const char c : heading)
            if (c == ' ' || c == '-')
                anchor += '-';
            else if (std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_')
                anchor += static_cast<char>(std::tolower(c));
        anchors.insert(anchor);
    }
    return anchors;
}

/// A page without its blocks of code, in which brackets are no links.
std::string prose_of(const fs::path& page)
{
    const std::string text = test::read_bytes(page), fence = "\n```";
    std::string prose;
    bool in_code = false;
    for (std::size_t at = 0; at < text.size(); in_code = !in_code) {
        const std::size_t end = std::min(text.find(fence, at), text.size());
        if (!in_code)
            prose += text.substr(at, end - at);
        at = end + fence.size();
    }
    return prose;
}

std::string without_spaces(std::string text)
{
    std::erase_if(text, [](char c) { return c == ' ' || c == '\n'; });
    return text;
}

TEST(Docs, EveryLinkLeadsToAFileAndAHeading)
{
    for (const fs::path& page : pages())
        for (const std::string& link : all_of(prose_of(page), "\\]\\(([^)]*)\\)")) {
            if (link.starts_with("http"))
                continue;
            const std::size_t hash = std::min(link.find('#'), link.size());
            const fs::path file = hash == 0 ? page : page.parent_path() / link.substr(0, hash);
            EXPECT_TRUE(fs::exists(file)) << page << ": " << link;
            EXPECT_TRUE(hash == link.size() || anchors_of(file).contains(link.substr(hash + 1)))
                << page << ": " << link;
        }
}

/// A longer README is one that nobody reads to its end.
TEST(Docs, TheReadmeIsShort)
{
    EXPECT_LE(fs::file_size(kRoot / "README.md"), 8000u);
}

TEST(Docs, EverySettingStandsWithItsValuesAndDefault)
{
    const std::string methods = test::read_bytes(kRoot / "docs" / "methods.md");
    for (const SettingInfo& info : setting_table()) {
        std::string row = "| `--" + std::string(info.name) + "` | ";
        for (const char c : info.values)
            row += c == '|' ? ", " : std::string(1, c);
        row += (info.unit.empty() ? "" : " ") + std::string(info.unit) + " | ";
        row += info.get(Settings{}) + " | ";
        EXPECT_NE(methods.find(row), std::string::npos) << "docs/methods.md has no row " << row;
    }
}

/// scripts/test compiles and runs that host.
TEST(Docs, TheLibrarysExampleIsTheHostsCode)
{
    const std::string host =
        without_spaces(test::read_bytes(kRoot / "tests" / "package" / "host_glad.cpp"));
    for (const char* page : {"README.md", "docs/library.md"}) {
        const std::string text = test::read_bytes(kRoot / page);
        const std::size_t start = text.find("```cpp\n") + 7;
        std::istringstream code(text.substr(start, text.find("```", start) - start));
        int lines = 0;
        for (std::string line; std::getline(code, line); ++lines) {
            const std::string statement = without_spaces(line.substr(0, line.find("//")));
            EXPECT_NE(host.find(statement), std::string::npos) << page << ": " << line;
        }
        EXPECT_GE(lines, 5) << page;
    }
}

TEST(Docs, TheExamplesOfTransparentsAreTheHostsCode)
{
    const std::string host =
        without_spaces(test::read_bytes(kRoot / "tests" / "package" / "host_glass.cpp"));
    const std::string text = test::read_bytes(kRoot / "docs" / "library.md");
    int examples = 0;
    for (std::size_t at = text.find("## A host's own transparents");
         (at = text.find("```cpp\n", at)) != std::string::npos; ++examples) {
        at += 7;
        const std::size_t end = text.find("```", at);
        std::istringstream code(text.substr(at, end - at));
        for (std::string line; std::getline(code, line);) {
            const std::string statement = without_spaces(line.substr(0, line.find("//")));
            EXPECT_NE(host.find(statement), std::string::npos) << line;
        }
        at = end;
    }
    EXPECT_EQ(examples, 2);
}

}  // namespace
}  // namespace fumarole
