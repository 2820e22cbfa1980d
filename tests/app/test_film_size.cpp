#include "app/film_size.h"

#include <gtest/gtest.h>

#include "irradia/Error.h"

namespace irradia::app {
namespace {

Scene film(unsigned width, unsigned height) {
    Scene scene;
    scene.source = "scene.bin";
    scene.info.width = width;
    scene.info.height = height;
    scene.info.camera.pixel_size = 0.01f;
    return scene;
}

TEST(FilmSize, OneSideFollowsTheOther) {
    Scene scene = film(1280, 720);
    set_film_size(scene, 320, 0);
    EXPECT_EQ(scene.info.width, 320u);
    EXPECT_EQ(scene.info.height, 180u);
    EXPECT_FLOAT_EQ(scene.info.camera.pixel_size, 0.04f);  // a quarter of the pixels a side, four times the edge

    scene = film(1280, 720);
    set_film_size(scene, 0, 1440);
    EXPECT_EQ(scene.info.width, 2560u);
    EXPECT_FLOAT_EQ(scene.info.camera.pixel_size, 0.005f);

    scene = film(1000, 10);
    set_film_size(scene, 20, 0);
    EXPECT_EQ(scene.info.height, 1u);  // never none
}

TEST(FilmSize, TwoZerosChangeNothing) {
    Scene scene = film(300, 200);
    set_film_size(scene, 0, 0);
    EXPECT_EQ(scene.info.width, 300u);
    EXPECT_EQ(scene.info.height, 200u);
    EXPECT_EQ(scene.info.camera.pixel_size, 0.01f);
}

TEST(FilmSize, ShapeMayNotChangeBeyondAPixelsRounding) {
    Scene scene = film(300, 200);
    set_film_size(scene, 100, 67);  // 66.7
    EXPECT_EQ(scene.info.height, 67u);
    scene = film(300, 200);
    EXPECT_THROW(set_film_size(scene, 100, 100), Error);
    EXPECT_EQ(scene.info.width, 300u);
}

// Widths: Mitsuba 3's documentation of its reconstruction filters (tent: radius 1; gaussian: stddev 0.5).
TEST(FilmFilter, HasMitsubasDefaultWidth) {
    Scene scene = film(4, 4);
    set_rfilter(scene, "gaussian");
    EXPECT_EQ(scene.info.rfilter, IR_RFILTER_GAUSSIAN);
    EXPECT_FLOAT_EQ(scene.info.rfilter_stddev, 0.5f);
    EXPECT_FLOAT_EQ(scene.info.rfilter_radius, 2.0f);
    set_rfilter(scene, "");
    EXPECT_EQ(rfilter_name(scene), "gaussian");
    set_rfilter(scene, "tent");
    EXPECT_EQ(rfilter_name(scene), "tent");
    EXPECT_FLOAT_EQ(scene.info.rfilter_radius, 1.0f);
    set_rfilter(scene, "box");
    EXPECT_EQ(rfilter_name(scene), "box");
    EXPECT_FLOAT_EQ(scene.info.rfilter_radius, 0.5f);
    EXPECT_THROW(set_rfilter(scene, "mitchell"), Error);
}

}  // namespace
}  // namespace irradia::app
