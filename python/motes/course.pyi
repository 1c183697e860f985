from motes_lab.course import *
