// Every command line of README.md and docs: run as a reader runs it, in a folder that has what the
// pages speak of, but smaller where it would take long; or on a list, with the reason.
#include <algorithm>
#include <array>
#include <filesystem>
#include <map>
#include <ostream>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "cli/fog_scene.h"
#include "cli/run_program.h"

namespace fumarole::test {
namespace {

namespace fs = std::filesystem;

const fs::path kRepository = fs::path(FUM_TEST_DATA).parent_path();

struct Section {
    std::string name;  ///< of the test: the page and the heading
    std::vector<std::string> commands;
};

void PrintTo(const Section& section, std::ostream* to)
{
    *to << section.name;
}

struct Part {
    std::string text, with;
};

/// What is made smaller. Each is found in some command.
const std::vector<Part> kSmaller{
    {"/shared/", ""},
    {"--frames 1..240", "--frames 1..2 --size=32x18"},
    {"--frames 1..48", "--frames 1..2"},
    {"--frames 0..95", "--frames 0..1"},
    {"--frames 1..8", "--frames 1..2"},
    {"--aa 8", "--aa 2"},
    {"--aa 16 -o s1.exr", "--aa 1 -o s1.exr"},  // of the size of what it is compared with
    {"--aa 16", "--aa 2"},
    {"--size 960x540", "--size 32x18"},
    {"--size 320x180", "--size 32x18"},
    {"--size 256", "--size 32"},
    {"--time-limit 200", "--time-limit 900"},  // on a busy machine too
    {"--tolerance 0.01", "--tolerance 0.3"},
    {"fumarole bench", "fumarole bench --quick --group lights --rounds 1 --frames 1"},
    {"fumarole stability", "fumarole stability --case slab-transmittance --preset default"},
    {"vdb_samples/smoke_plume.json --quick", "smoke.json --quick --shard 1/8"},
    {"fumarole chart smoke.json --tolerance", "fumarole chart smoke.json --quick --tolerance"},
    {"fumarole plan", "fumarole plan --time-limit=4 --size=64x36 --bounces=0"},
};

/// Programs other than fumarole, and why no test of this file runs them.
const std::map<std::string, std::string> kNotRun{
    {"scripts/demo", "installs packages and opens a window"},
    {"scripts/test", "runs this test"},
    {"scripts/check shaders tidy", "goes over all files for an hour"},
    {"scripts/check chip", "needs packages beyond packages.txt"},
    {"scripts/second_opinion BUILD softpipe|zink", "is the test gpu_softpipe of `ctest -C second`"},
    {"ctest -C second", "runs for minutes on drivers that may not be there"},
    {"ctest -C farm -L farm", "needs a Slurm, and is a test of ctest itself"},
    {"cmake --preset release", "built this program, or another preset did"},
    {"cmake --build --preset release", "built this program, or another preset did"},
    {"cmake --install build/release", "is what the test `package` does"},
    {"cd build/release", "is no program"},
    {"cpack -G DEB", "is `scripts/check package`"},
    {"apt install ./fumarole_*.deb", "would install it on this machine"},
    {"PYTHONPATH=build/release/python python3 -c 'import fumarole; print(fumarole.__version__)'",
     "needs the module, which the test `python` imports from its own folder"},
};

/// What some of them say here instead of ending with 0.
const std::map<std::string, std::string> kRefusedHere{
    {"fumarole view smoke.vdb", "no window can be opened: "},
    {"fumarole view 'smoke_####.vdb'", "no window can be opened: "},
    {"fumarole view vdb_samples/smoke_plume.json --script actions.json --frames 1 --json",
     "no window can be opened: "},
    {"fumarole render smoke.vdb --device 1", "--device: no '1'; there is: "},
};

std::string trimmed(const std::string& text)
{
    const std::size_t begin = text.find_first_not_of(' '), end = text.find_last_not_of(' ');
    return begin == std::string::npos ? "" : text.substr(begin, end - begin + 1);
}

/// The commands of a line of a block of `sh`, and the one that its comment may name.
void add_commands(const std::string& line, std::vector<std::string>& commands)
{
    const std::size_t hash = line.starts_with('#') ? 0 : std::min(line.find(" #"), line.size());
    std::string code = line.substr(0, hash);
    for (std::size_t at = 0; at <= code.size();) {
        const std::size_t end = std::min(code.find("&&", at), code.size());
        std::string command = trimmed(code.substr(at, end - at));
        if (command.starts_with("exec "))
            command = command.substr(5);
        if (!command.empty())
            commands.push_back(command);
        at = end + 2;
    }
    const std::string comment = line.substr(hash);
    if (std::smatch match; std::regex_search(comment, match, std::regex("fumarole [a-z].*")))
        commands.push_back(trimmed(match.str()));
}

/// In the prose of a page, of several lines: what stands in backticks and begins with a program
/// and a word for it.
void add_spans(const std::string& prose, std::vector<std::string>& commands)
{
    const std::regex span("`([^`]+)`");
    const std::regex program("(fumarole [a-z]|scripts/[a-z_]+( |$)|ctest |cmake |cpack |apt ).*");
    for (std::sregex_iterator it(prose.begin(), prose.end(), span), end; it != end; ++it) {
        std::string text = (*it)[1];
        std::replace(text.begin(), text.end(), '\n', ' ');
        if (std::regex_match(text, program))
            commands.push_back(text);
    }
}

/// README.md and docs, cut at their headings of the second order; those alone that have commands.
std::vector<Section> read_sections()
{
    std::vector<fs::path> pages{kRepository / "README.md"};
    for (const auto& entry : fs::directory_iterator(kRepository / "docs"))
        if (entry.path().extension() == ".md")
            pages.push_back(entry.path());
    std::sort(pages.begin() + 1, pages.end());
    std::vector<Section> sections;
    for (const fs::path& page : pages) {
        std::istringstream text(read_bytes(page));
        std::string fence, prose, block;
        const auto begin = [&](const std::string& heading) {
            Section section{page.stem().string() + "_" + heading, {}};
            for (char& c : section.name)
                c = std::isalnum(static_cast<unsigned char>(c)) != 0 ? c : '_';
            sections.push_back(section);
        };
        const auto end_prose = [&] {
            add_spans(prose, sections.back().commands);
            prose.clear();
        };
        begin("top");
        for (std::string line; std::getline(text, line);) {
            if (line.starts_with("```")) {
                if (fence.empty())
                    end_prose();
                fence = fence.empty() ? line : "";
            } else if (fence == "```sh") {
                if (line.ends_with('\\')) {
                    block += line.substr(0, line.size() - 1);
                    continue;
                }
                add_commands(block + line, sections.back().commands);
                block.clear();
            } else if (fence.empty()) {
                if (line.starts_with("## ")) {
                    end_prose();
                    begin(line.substr(3));
                }
                prose += line + "\n";
            }
        }
        end_prose();
    }
    std::erase_if(sections, [](const Section& section) { return section.commands.empty(); });
    return sections;
}

/// As a shell splits a line of plain words and single quotes.
Arguments words_of(const std::string& line)
{
    Arguments words;
    bool quoted = false, open = false;
    for (const char c : line) {
        if (c == '\'') {
            quoted = !quoted;
        } else if (c == ' ' && !quoted) {
            open = false;
            continue;
        }
        if (!open)
            words.emplace_back();
        open = true;
        if (c != '\'')
            words.back() += c;
    }
    return words;
}

std::string replaced(std::string text, const std::string& what, const std::string& with)
{
    for (std::size_t at = 0; (at = text.find(what, at)) != std::string::npos; at += with.size())
        text.replace(at, what.size(), with);
    return text;
}

std::string smaller(std::string line)
{
    for (const Part& part : kSmaller)
        line = replaced(line, part.text, part.with);
    const auto has = [&](const char* option) { return line.find(option) != std::string::npos; };
    const bool picture = line.starts_with("fumarole render ");
    const bool drawn = picture && !has("--mode reference");
    if (has(" s1.exr") || has("--help"))
        return line;
    if ((picture || line.starts_with("fumarole chart ")) && !has("--size"))
        line += " --size=32x18";
    if (drawn && !has("--aa") && !has("--show"))
        line += " --aa=1";
    if ((drawn || has("--modes")) && !has("--bounces"))
        line += " --bounces=0";
    if (drawn)
        line += " --ambient-volume-size=8 --shadow-volume-size=16";
    return line;
}

class DocumentedCommands : public testing::TestWithParam<Section> {
protected:
    /// What the pages speak of.
    DocumentedCommands()
    {
        unsetenv("DISPLAY");
        const fs::path here = folder_.path(), samples = FUM_TEST_DATA;
        fs::create_directory_symlink(samples, here / "vdb_samples");
        fs::create_directory_symlink(kRepository / "tests", here / "tests");
        fs::create_symlink(samples / "smoke_seq/smoke_0003.vdb", here / "smoke.vdb");
        for (const auto& frame : fs::directory_iterator(samples / "smoke_seq"))
            fs::create_symlink(frame.path(), here / frame.path().filename());
        for (const char* picture : {"a.exr", "b.exr"})
            fs::copy_file(kRepository / "tests/reference/S2_composite.exr", here / picture);
        for (const char* scene : {"scene.json", "smoke.json"})
            folder_.write(scene, fog_scene("[32, 18]", R"({"type": "box", "min": [-1, -1, 0],
                "max": [1, 1, 2], "profile": "homogeneous", "sigma_s": [0.5, 0.5, 0.5],
                "sigma_a": [0.1, 0.2, 0.3], "g": 0.2})"));
        folder_.write("actions.json", "[]");
        fs::create_directory(here / "out");
    }

    [[nodiscard]] Outcome run(const std::string& line) const
    {
        Arguments words = words_of(line);
        words.erase(words.begin());
        return run_program(folder_.path(), words);
    }

    TempFolder folder_;
};

TEST_P(DocumentedCommands, Run)
{
    for (const std::string& command : GetParam().commands) {
        if (kNotRun.contains(command))
            continue;
        if (command.starts_with("scripts/") && words_of(command).size() == 1) {  // it names a file
            EXPECT_TRUE(fs::exists(kRepository / command)) << command;
            continue;
        }
        ASSERT_TRUE(command.starts_with("fumarole "))
            << command << ": run it here, or say in kNotRun why not";
        if (words_of(command).size() == 2) {  // it names a command
            EXPECT_EQ(run(command + " --help").code, 0) << command;
            continue;
        }
        const std::string line = smaller(command);
        if (const auto refused = kRefusedHere.find(command); refused != kRefusedHere.end()) {
            const Outcome outcome = run(line);
            EXPECT_TRUE(outcome.code == 0 || outcome.err.find(refused->second) != std::string::npos)
                << line << '\n'
                << outcome;
            continue;
        }
        // One of the shares is named, and all are run.
        const bool shares = line.find("--shard 2/4") != std::string::npos;
        for (const char share : std::string(shares ? "1234" : "2")) {
            const std::string one =
                replaced(replaced(line, "--shard 2", "--shard " + std::string(1, share)),
                         "-o part2", "-o part" + std::string(1, share));
            const Outcome outcome = run(one);
            EXPECT_EQ(outcome.code, 0) << command << "\nas " << one << '\n' << outcome;
        }
    }
}

INSTANTIATE_TEST_SUITE_P(Docs, DocumentedCommands, testing::ValuesIn(read_sections()),
                         [](const auto& test) {
                             return std::to_string(test.index) + "_" + test.param.name;
                         });

TEST(DocumentedCommandLists, HoldWhatThePagesHave)
{
    std::set<std::string> commands;
    for (const Section& section : read_sections())
        commands.insert(section.commands.begin(), section.commands.end());
    EXPECT_GE(commands.size(), 50u);
    for (const auto* list : {&kNotRun, &kRefusedHere})
        for (const auto& [command, reason] : *list)
            EXPECT_TRUE(commands.contains(command)) << command << ": no page has it any more";
    for (const Part& part : kSmaller)
        EXPECT_TRUE(std::any_of(commands.begin(), commands.end(),
                                [&](const std::string& command) {
                                    return command.find(part.text) != std::string::npos;
                                }))
            << part.text << ": no command has it any more";
    // The parser itself, by what is known to stand in each place.
    for (const char* known :
         {"scripts/demo", "fumarole render smoke.vdb -o smoke.png",
          "fumarole view 'smoke_####.vdb'", "cpack -G DEB", "fumarole render --help",
          "fumarole render smoke.json --frames 1..240 --resume --aa 8 --exposure 1.5 -o "
          "'/shared/out/smoke.####.exr'"})
        EXPECT_TRUE(commands.contains(known)) << known;
}

}  // namespace
}  // namespace fumarole::test
