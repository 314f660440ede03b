import fmpy

from master.fmi import platforms


def test_the_names_of_this_platform_are_those_of_fmpy():
    assert fmpy.platform == platforms.FMI2_FOLDER
    assert fmpy.platform_tuple == platforms.FMI3_FOLDER
    assert fmpy.sharedLibraryExtension == platforms.LIBRARY_SUFFIX
