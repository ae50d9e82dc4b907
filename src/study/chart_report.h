#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "study/chart.h"

namespace fumarole::study {

/// What a report tells besides the chart itself.
struct ReportFacts {
    std::string title;    ///< title of the scene
    std::string command;  ///< how a point of it is rendered, up to the settings:
                          ///< `fumarole render smoke.vdb --size 480x270`
    std::vector<std::pair<std::string, std::string>> machine;  ///< `renderer`, `llvmpipe`; ...
    std::filesystem::path chart_png;                           ///< "" if there is none
    std::filesystem::path reference_file;
};

/// The pictures of a point on the front.
struct FrontPicture {
    const MeasuredPoint* point;
    std::string png, difference_png;  ///< files' bytes
};

/// Renders the points on the front once more, and how each differs from the reference, all in one
/// scale, that of the middle one. Pictures wider than 480 pixels are halved until they are not.
/// `folder` holds each file for a moment. @throws ChartCancelled between pictures
std::vector<FrontPicture> front_pictures(const Chart& chart, const Scene& scene,
                                         const ReferenceStill& reference, SceneRenderer& renderer,
                                         const std::filesystem::path& folder,
                                         const std::atomic<bool>* cancel = nullptr);

/// One file of HTML, all pictures inside. @throws Error if the chart's picture can't be read.
std::string report_html(const Chart& chart, const ReportFacts& facts,
                        const std::vector<FrontPicture>& pictures);

/// &, <, >, " and ' made harmless.
std::string html_text(std::string_view text);

}  // namespace fumarole::study
