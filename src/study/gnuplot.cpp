#include "study/gnuplot.h"

#include <fmt/format.h>

#include "asset/printable.h"
#include "study/child_process.h"
#include "write/whole_file.h"
#include <fumarole/errors.h>

namespace fumarole::study {

std::string in_quotes(std::string_view text)
{
    std::string out = "'";
    for (const char c : asset::printable(text, 200))
        out += c == '\'' ? std::string("''") : std::string(1, c);
    return out + "'";
}

std::string data_block(const std::string& name, const std::string& rows)
{
    return fmt::format("${} << EOD\n{}EOD\n", name, rows);
}

void run_gnuplot(const std::string& program, const std::filesystem::path& folder)
{
    const write::UnfinishedFile file(folder / "program.gnuplot");
    write::write_whole(file.path(), program);
    const ChildResult run = run_child({"gnuplot", file.path().string()}, folder / "gnuplot.log");
    if (!run.found)
        throw Error("gnuplot is not installed, which draws the plot: apt-get install gnuplot-nox; "
                    "the measured points are kept in the other files");
    if (run.code != 0)
        throw Error("gnuplot failed: " + asset::printable(run.said, 400));
}

}  // namespace fumarole::study
