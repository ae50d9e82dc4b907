#pragma once

#include <functional>

#include "host_picture.h"

namespace fumarole::test {

/// What a mode keeps of a view from frame to frame.
class HistoryTest : public ImageTest {
protected:
    /// Frames of a view; layers are the last one's. @returns its report.
    FrameReport run(Renderer& renderer, View& view, const Scene& scene, const Settings& settings,
                    int frames = 1, std::uint64_t first = 0);

    /// A view meets, one after the other, all that makes what is kept worthless, says so, and shows
    /// what one without a past does.
    /// @param scene something about (0, -5, 0) in a sun, the eye at the origin
    /// @param others settings that differ in what the picture depends on
    /// @param fresh scattering of a frame of that number, of a view without a past
    void expect_dropped_for_reasons(
        Scene scene, Settings settings, const Settings& others,
        const std::function<std::vector<float>(const Scene&, const Settings&,
                                               std::uint64_t number)>& fresh);

    LayerImages layers;
};

}  // namespace fumarole::test
