import fmpy

from master.fmi import platforms


def test_the_names_of_this_platform_are_those_of_fmpy():
    assert platforms.FMI2_FOLDER == fmpy.platform
    assert platforms.FMI3_FOLDER == fmpy.platform_tuple
    assert platforms.LIBRARY_SUFFIX == fmpy.sharedLibraryExtension
