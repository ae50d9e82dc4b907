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
#include "window/keys.h"

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

TEST(Docs, EveryKeyOfTheWindowStandsInItsTable)
{
    const std::string viewer = test::read_bytes(kRoot / "docs" / "viewer.md");
    std::string rows;
    std::istringstream text(viewer);
    for (std::string line; std::getline(text, line);)
        if (line.starts_with("| `"))
            rows += line.substr(0, line.find(" | ")) + " |\n";
    for (const window::KeyBinding& binding : window::key_table())
        EXPECT_NE(rows.find("`" + std::string(binding.name) + "`"), std::string::npos)
            << "docs/viewer.md has no row for " << binding.name;
}

/// Letters as the code spells them.
std::string in_ascii(std::string text)
{
    const std::vector<std::pair<std::string, std::string>> letters{
        {"é", "e"}, {"á", "a"},  {"ñ", "n"},  {"ř", "r"},
        {"ü", "u"}, {"ä", "ae"}, {"ö", "oe"}, {"Å", "A"}};
    for (const auto& [letter, plain] : letters)
        for (std::size_t at = 0; (at = text.find(letter, at)) != std::string::npos;)
            text.replace(at, letter.size(), plain);
    return text;
}

/// A source file on one line, without what begins the lines of a comment.
std::string joined_lines(const fs::path& file)
{
    return std::regex_replace(in_ascii(test::read_bytes(file)), std::regex("\n *(///?)? *"), " ");
}

TEST(Docs, TheReferencesAreWhatTheCodeCites)
{
    std::vector<std::string> rows;
    std::istringstream page(in_ascii(test::read_bytes(kRoot / "docs" / "references.md")));
    for (std::string line; std::getline(page, line);)
        if (line.starts_with("| ") && !line.starts_with("| source"))
            rows.push_back(line);
    EXPECT_GE(rows.size(), 50u);

    // Each file that a row names cites it: one of its names, its year near by.
    for (const std::string& row : rows) {
        const std::string source = row.substr(0, row.find('*'));
        const std::vector<std::string> years = all_of(source, "((19|20)[0-9]{2})");
        const std::vector<std::string> files = all_of(row, "`((?:src|glsl|viewer)/[^`]*)`");
        EXPECT_FALSE(files.empty()) << row;
        for (const std::string& file : files) {
            ASSERT_TRUE(fs::exists(kRoot / file)) << file;
            const std::string text = joined_lines(kRoot / file);
            bool cited = false;
            for (const std::string& name : all_of(source, "([A-Z][A-Za-z-]+|pbrt)"))
                cited = cited || text.find(name) != std::string::npos;
            EXPECT_TRUE(cited || source.find("Pharr") != std::string::npos) << file << ": " << row;
        }
    }

    // And what the code cites, "Name 2001" or "Name and others 2001", has a row.
    const std::regex citation("([A-Z][a-z]+(?:-[A-Z][a-z]+)?)(?: et al\\.| and others)?,? "
                              "((?:19|20)[0-9]{2})\\b");
    const std::set<std::string> no_names{"July", "October", "Mesa", "Eevee", "Box"};
    std::size_t citations = 0;
    for (const char* folder : {"src", "glsl", "viewer"})
        for (const auto& entry : fs::recursive_directory_iterator(kRoot / folder)) {
            if (!entry.is_regular_file() || entry.path().extension() == ".py")
                continue;
            const std::string text = joined_lines(entry.path());
            for (std::sregex_iterator it(text.begin(), text.end(), citation), end; it != end;
                 ++it) {
                const std::string name = (*it)[1], year = (*it)[2];
                if (no_names.contains(name))
                    continue;
                ++citations;
                EXPECT_TRUE(std::any_of(rows.begin(), rows.end(),
                                        [&](const std::string& row) {
                                            return row.find(name) != std::string::npos &&
                                                   row.find(year) != std::string::npos;
                                        }))
                    << entry.path() << " cites " << name << ' ' << year
                    << ", which docs/references.md has not";
            }
        }
    EXPECT_GE(citations, 60u);
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
