// What a package has of the program: its manual page, what shells complete, thumbnails, and the
// files of a desktop.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <regex>
#include <set>

#include "pictures/table.h"
#include "run_program.h"
#include "support/temp_folder.h"

namespace fumarole::test {
namespace {

using testing::HasSubstr;

const std::filesystem::path kPackaging =
    std::filesystem::path(FUM_TEST_DATA).parent_path() / "packaging";

/// Every `--option` of a text.
std::set<std::string> options_in(const std::string& text)
{
    static const std::regex kOption("--[a-z][-a-z0-9]*");
    return {std::sregex_token_iterator(text.begin(), text.end(), kOption),
            std::sregex_token_iterator()};
}

/// What bash completes a command line with.
std::string completed(const std::filesystem::path& script, const std::string& words, int at)
{
    const auto out = script.parent_path() / "completed";
    const std::string line = "bash -c 'source " + script.string() + "; COMP_WORDS=(" + words +
                             "); COMP_CWORD=" + std::to_string(at) +
                             "; _fumarole; echo ${COMPREPLY[*]}' > " + out.string();
    EXPECT_EQ(std::system(line.c_str()), 0);
    return read_bytes(out);
}

TEST(Packaging, ManualAndCompletionHaveEveryOptionOfEveryCommand)
{
    const TempFolder folder;
    const std::string bash = run_program(folder.path(), {"completion", "bash"}).out,
                      zsh = run_program(folder.path(), {"completion", "zsh"}).out;
    std::string page = run_program(folder.path(), {"manual"}).out;
    page = std::regex_replace(page, std::regex("\\\\-"), "-");
    const std::string help = run_program(folder.path(), {"--help"}).out;
    for (const char* command :
         {"info", "render", "compare", "chart", "plan", "stability", "bench", "view"}) {
        ASSERT_THAT(help, HasSubstr(command));
        for (const std::string& option :
             options_in(run_program(folder.path(), {command, "--help"}).out)) {
            EXPECT_TRUE(options_in(bash).contains(option)) << command << " " << option;
            EXPECT_TRUE(options_in(zsh).contains(option)) << command << " " << option;
            EXPECT_TRUE(options_in(page).contains(option)) << command << " " << option;
        }
    }
    for (const char* hidden : {"completion", "thumbnail", "manual"})
        EXPECT_THAT(help, testing::Not(HasSubstr(hidden)));
    const auto script = folder.write("fumarole.bash", bash);
    EXPECT_EQ(completed(script, "fumarole re", 1), "render\n");
    EXPECT_EQ(completed(script, "fumarole render --mod", 2), "--mode\n");
    EXPECT_EQ(completed(script, "fumarole render --mode \"\"", 3), "raymarch froxel reference\n");
    EXPECT_EQ(completed(script, "fumarole render --jitter b", 3), "blue\n");
    // A number or a name is none of the folder's files.
    folder.write("smoke.png", "");
    EXPECT_EQ(completed(script, "fumarole render --size \"\"", 3), "\n");
    EXPECT_EQ(completed(script, "fumarole render -o " + (folder.path() / "smo").string(), 3),
              (folder.path() / "smoke.png").string() + "\n");
    EXPECT_EQ(completed(script, "fumarole chart -o " + (folder.path() / "smo").string(), 3), "\n");
    EXPECT_THAT(zsh, HasSubstr("'*--size[width and height"));
    EXPECT_THAT(zsh, HasSubstr(":WxH: '"));
    EXPECT_THAT(page, HasSubstr(".BI \"--size \" \"WxH\""));
    EXPECT_EQ(run_program(folder.path(), {"completion", "fish"}).code, 2);
    if (std::system("command -v zsh > /dev/null") == 0) {
        EXPECT_EQ(std::system(("zsh -n " + folder.write("_fumarole", zsh).string()).c_str()), 0);
    }
    if (std::system("command -v man > /dev/null") == 0) {
        const auto file = folder.write("fumarole.1", run_program(folder.path(), {"manual"}).out);
        EXPECT_EQ(std::system(("test -z \"$(MANWIDTH=80 man --warnings -E UTF-8 -l -Tutf8 -Z " +
                               file.string() + " 2>&1 >/dev/null)\"")
                                  .c_str()),
                  0);
    }
}

TEST(Packaging, AThumbnailIsOfTheSizeThatIsAskedFor)
{
    const TempFolder folder;
    const auto file = folder.path() / "thumbnail-without-extension";
    const auto smoke = std::filesystem::path(FUM_TEST_DATA) / "smoke_seq" / "smoke_0006.vdb";
    ASSERT_EQ(
        run_program(folder.path(), {"thumbnail", "--size", "32", smoke.string(), file.string()})
            .code,
        0);
    const std::string bytes = read_bytes(file);
    ASSERT_GT(bytes.size(), 24u);
    EXPECT_EQ(bytes.substr(1, 3), "PNG");
    EXPECT_EQ(int(bytes[19]), 32);
    EXPECT_EQ(int(bytes[23]), 24);
    // By which a desktop, and our window, know what it is of.
    EXPECT_THAT(bytes, HasSubstr("file://" + smoke.parent_path().lexically_normal().string()));
    EXPECT_THAT(bytes, HasSubstr("Thumb::MTime"));
    EXPECT_EQ(run_program(folder.path(), {"thumbnail", "none.vdb", file.string()}).code, 1);
}

/// Exit code and what was said on stderr, by a copy of the program.
std::pair<int, std::string> said(const std::filesystem::path& program, const std::string& arguments)
{
    const auto file = program.parent_path() / "said";
    const int status = std::system(
        (program.string() + " " + arguments + " 2> " + file.string() + " > /dev/null").c_str());
    return {WEXITSTATUS(status), read_bytes(file)};
}

/// 250 libraries that a command without a picture needn't wait for.
TEST(Packaging, OpenImageIOIsOpenedForPicturesAlone)
{
    const TempFolder folder;
    const auto libraries = folder.path() / "libraries";
    ASSERT_EQ(
        std::system(("LD_TRACE_LOADED_OBJECTS=1 " FUM_PROGRAM " > " + libraries.string()).c_str()),
        0);
    EXPECT_THAT(read_bytes(libraries), HasSubstr("libopenvdb"));
    EXPECT_THAT(read_bytes(libraries), testing::Not(HasSubstr("OpenImageIO")));

    // A level down: the folder that the module is installed in must be the test's own, too.
    const auto bin = folder.path() / "bin", program = bin / "fumarole",
               module = bin / pictures::kModule;
    std::filesystem::create_directory(bin);
    std::filesystem::copy_file(FUM_PROGRAM, program);
    const std::string start = "render --size 8x8 --aa 1 --bounces 0 " +
                              sample("smoke_seq/smoke_0006.vdb") + " -o " + folder.path().string();
    const std::string render = start + "/a.exr";
    EXPECT_EQ(said(program, start + "/a.png"), std::pair(0, std::string()));
    const auto [missing, what_misses] = said(program, render);
    EXPECT_EQ(missing, 1);
    EXPECT_THAT(what_misses, testing::AllOf(HasSubstr("fumarole-pictures.so: is not there"),
                                            HasSubstr("install fumarole anew")));
    folder.write(std::string("bin/") + pictures::kModule, "no library");
    const auto [broken, what_breaks] = said(program, render);
    EXPECT_EQ(broken, 1);
    EXPECT_THAT(what_breaks, HasSubstr(module.string() + ": can't be opened"));
    std::filesystem::remove(module);
    std::filesystem::create_symlink(
        std::filesystem::path(FUM_PROGRAM).parent_path() / pictures::kModule, module);
    EXPECT_EQ(said(program, render).first, 0);
}

TEST(Packaging, FilesOfADesktopAreWhatTheirCheckersTake)
{
    for (const char* name : {"fumarole.desktop", "fumarole.thumbnailer", "fumarole-mime.xml"})
        for (const char* type : {"application/x-openvdb", "application/x-nanovdb"})
            EXPECT_THAT(read_bytes(kPackaging / name), HasSubstr(type)) << name;
    std::string missing;
    for (const auto& [checker, command] :
         {std::pair{"desktop-file-validate",
                    "desktop-file-validate " + (kPackaging / "fumarole.desktop").string()},
          {"appstreamcli", "appstreamcli validate --no-net " +
                               (kPackaging / "org.fumarole.Fumarole.metainfo.xml").string()},
          {"xmllint", "xmllint --noout " + (kPackaging / "fumarole-mime.xml").string() + " " +
                          (kPackaging / "fumarole.svg").string()}}) {
        if (std::system((std::string("command -v ") + checker + " > /dev/null").c_str()) != 0) {
            missing += std::string(" ") + checker;
            continue;
        }
        EXPECT_EQ(std::system((command + " > /dev/null").c_str()), 0) << command;
    }
    if (!missing.empty())
        GTEST_SKIP() << "not installed, and nothing was checked by it:" << missing
                     << " (scripts/check_packages.txt)";
}

}  // namespace
}  // namespace fumarole::test
